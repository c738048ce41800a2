// SPDX-License-Identifier: MIT
// Run-time dispatch for programs that must run on any x86-64: with NLO_CPU_DISPATCH defined, networks, their
// forward-mode derivatives, gated units and batches are compiled for AVX2 and AVX-512 too. The first evaluation asks
// the CPU for its instruction sets; every later one costs a load and a jump. There is no ifunc and no static
// initialiser, so that observers also work during static initialisation. If the compiler may use AVX-512 anyway, the
// macro has no effect.
#pragma once

#include "nlo/kernels/panels.h"

#if defined(NLO_CPU_DISPATCH) && defined(__x86_64__) && !defined(__AVX512F__) && !defined(NLO_SCALAR_KERNELS)
#define NLO_DISPATCHES 1

#define NLO_TARGET_AVX2 target("avx2,fma,f16c")
#define NLO_TARGET_AVX512 target("avx2,fma,f16c,avx512f,avx512bw,avx512dq,avx512vl")
#define NLO_CODE_AVX2 inline __attribute__((always_inline, NLO_TARGET_AVX2))
#define NLO_CODE_AVX512 inline __attribute__((always_inline, NLO_TARGET_AVX512))

namespace nlo::inline NLO_ISA::kernels::x86 {

namespace avx2 {
using namespace nlo::simd::types;
#define NLO_CODE NLO_CODE_AVX2
#define NLO_CODE_SHARED __attribute__((noinline, NLO_TARGET_AVX2))
#define NLO_ISA_BYTES 32
#define NLO_ISA_WIDE_LOADS 2
#include "nlo/kernels/per_isa/one_isa.inc"
#undef NLO_ISA_WIDE_LOADS
#undef NLO_ISA_BYTES
#undef NLO_CODE_SHARED
#undef NLO_CODE
}  // namespace avx2

namespace avx512 {
using namespace nlo::simd::types;
#define NLO_CODE NLO_CODE_AVX512
#define NLO_CODE_SHARED __attribute__((noinline, NLO_TARGET_AVX512))
#define NLO_ISA_BYTES 64
#define NLO_ISA_WIDE_LOADS 2
#include "nlo/kernels/per_isa/one_isa.inc"
#undef NLO_ISA_WIDE_LOADS
#undef NLO_ISA_BYTES
#undef NLO_CODE_SHARED
#undef NLO_CODE
}  // namespace avx512

// Same bits as avx512. Only the instructions that broadcast an input to all lanes differ.
namespace avx512_one_load {
using namespace nlo::simd::types;
#define NLO_CODE NLO_CODE_AVX512
#define NLO_CODE_SHARED __attribute__((noinline, NLO_TARGET_AVX512))
#define NLO_ISA_BYTES 64
#define NLO_ISA_WIDE_LOADS 1
#include "nlo/kernels/per_isa/one_isa.inc"
#undef NLO_ISA_WIDE_LOADS
#undef NLO_ISA_BYTES
#undef NLO_CODE_SHARED
#undef NLO_CODE
}  // namespace avx512_one_load

enum class Level : int { kUnknown, kBaseline, kAvx2, kAvx512, kAvx512OneLoad };

/// Asks the CPU for its instruction sets. The builtins also check that the operating system saves the registers.
inline Level ask_cpu() {
  __builtin_cpu_init();
  // Every CPU with AVX2 has F16C, whose name clang's builtin does not know.
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return Level::kBaseline;
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  if (!avx512) return Level::kAvx2;
  return __builtin_cpu_is("amdfam19h") ? Level::kAvx512OneLoad
                                       : Level::kAvx512;  // Zen 4: one load of 64 bytes per cycle
}

constexpr bool has_avx512(Level level) {
  return level == Level::kAvx512 || level == Level::kAvx512OneLoad;
}

/// The level in use: kUnknown until the first evaluation asks the CPU. Tests store each level that the CPU can execute.
inline constinit int level_in_use = static_cast<int>(Level::kUnknown);

/// Returns the level in use. Asks the CPU once; threads that ask at the same time store the same answer.
inline Level level() {
  const int known = __atomic_load_n(&level_in_use, __ATOMIC_RELAXED);
  if (known != static_cast<int>(Level::kUnknown)) [[likely]]
    return static_cast<Level>(known);
  const Level level = ask_cpu();
  __atomic_store_n(&level_in_use, static_cast<int>(level), __ATOMIC_RELAXED);
  return level;
}

/// Calls the function that suits the CPU. Returns false if the CPU has neither AVX2 nor AVX-512.
template <class OfOneLoad, class OfAvx512, class OfAvx2>
NLO_INLINE bool dispatched(const OfOneLoad& of_one_load, const OfAvx512& of_avx512, const OfAvx2& of_avx2) {
  const Level found = level();
  if (found == Level::kAvx512OneLoad) {
    of_one_load();
  } else if (found == Level::kAvx512) {
    of_avx512();
  } else if (found == Level::kAvx2) {
    of_avx2();
  }
  return has_avx512(found) || found == Level::kAvx2;
}

template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX2)) void evaluate_avx2(const Network& net, const Scalar* in, Scalar* out,
                                                              Scalar* ping, Scalar* pong) {
  avx2::network<kKind, kArithmetic>(net, in, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void evaluate_avx512(const Network& net, const Scalar* in, Scalar* out,
                                                                  Scalar* ping, Scalar* pong) {
  avx512::network<kKind, kArithmetic>(net, in, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void evaluate_one_load(const Network& net, const Scalar* in, Scalar* out,
                                                                    Scalar* ping, Scalar* pong) {
  avx512_one_load::network<kKind, kArithmetic>(net, in, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic, int kPlants, class Network, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX2)) void evaluate_batch_avx2(const Network& net, const Scalar* in, Scalar* out,
                                                                    Scalar* ping, Scalar* pong) {
  avx2::batch_network<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic, int kPlants, class Network, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void evaluate_batch_avx512(const Network& net, const Scalar* in,
                                                                        Scalar* out, Scalar* ping, Scalar* pong) {
  avx512::batch_network<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic = Arithmetic::kFast, class Network, class Scalar, class Buffer>
__attribute__((noinline, NLO_TARGET_AVX2)) void jvp_avx2(const Network& net, const Scalar* in, const Scalar* direction,
                                                         Scalar* out, Buffer& ping, Buffer& pong) {
  avx2::network_jvp<kKind, kArithmetic>(net, in, direction, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic = Arithmetic::kFast, class Network, class Scalar, class Buffer>
__attribute__((noinline, NLO_TARGET_AVX512)) void jvp_avx512(const Network& net, const Scalar* in,
                                                             const Scalar* direction, Scalar* out, Buffer& ping,
                                                             Buffer& pong) {
  avx512::network_jvp<kKind, kArithmetic>(net, in, direction, out, ping, pong);
}

template <Activation kKind, Arithmetic kArithmetic = Arithmetic::kFast, class Network, class Scalar, class Buffer>
__attribute__((noinline, NLO_TARGET_AVX512)) void jvp_one_load(const Network& net, const Scalar* in,
                                                               const Scalar* direction, Scalar* out, Buffer& ping,
                                                               Buffer& pong) {
  avx512_one_load::network_jvp<kKind, kArithmetic>(net, in, direction, out, ping, pong);
}

}  // namespace nlo::inline NLO_ISA::kernels::x86

#endif
