// SPDX-License-Identifier: MIT
#include "bench/cache.h"

namespace nlo::bench {
namespace {

#if defined(__x86_64__)

__attribute__((target("avx512f"))) void load_64(const char* from, const char* end) {
  for (; from != end; from += 512) {
    asm volatile(
        "vmovaps (%0), %%zmm0\nvmovaps 64(%0), %%zmm1\nvmovaps 128(%0), %%zmm2\nvmovaps 192(%0), %%zmm3\n"
        "vmovaps 256(%0), %%zmm4\nvmovaps 320(%0), %%zmm5\nvmovaps 384(%0), %%zmm6\nvmovaps 448(%0), %%zmm7\n"
        :
        : "r"(from)
        : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7");
  }
}

__attribute__((target("avx"))) void load_32(const char* from, const char* end) {
  for (; from != end; from += 256) {
    asm volatile(
        "vmovaps (%0), %%ymm0\nvmovaps 32(%0), %%ymm1\nvmovaps 64(%0), %%ymm2\nvmovaps 96(%0), %%ymm3\n"
        "vmovaps 128(%0), %%ymm4\nvmovaps 160(%0), %%ymm5\nvmovaps 192(%0), %%ymm6\nvmovaps 224(%0), %%ymm7\n"
        :
        : "r"(from)
        : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7");
  }
}

#endif

void load_16(const char* from, const char* end) {
  typedef float Four __attribute__((vector_size(16)));
  for (; from != end; from += 16) {
    const Four four = *reinterpret_cast<const Four*>(from);
#if defined(__SSE2__)
    asm volatile("" : : "x"(four));
#elif defined(__aarch64__)
    asm volatile("" : : "w"(four));
#else
    asm volatile("" : : "m"(four));
#endif
  }
}

}  // namespace

void load_all(const void* from, std::size_t bytes) {
  const char* const first = static_cast<const char*>(from);
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return load_64(first, first + bytes);
  if (__builtin_cpu_supports("avx")) return load_32(first, first + bytes);
#endif
  load_16(first, first + bytes);
}

}  // namespace nlo::bench
