// SPDX-License-Identifier: MIT
// Weights of 16 bits, which are converted to float for the computation. They halve the size of networks that do not
// stay in the cache between two samples, or that do not fit into the flash. `nlo export` rounds the weights; the
// literals in the header are exact.
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA {

/// bfloat16: float's range, 8 bits of precision (relative rounding 2^-9).
struct Bfloat16 {
  std::uint16_t bits = 0;

  constexpr Bfloat16() = default;
  /// Rounds to nearest, ties to even. Not for NaN.
  constexpr explicit(false) Bfloat16(float value) {
    const auto whole = std::bit_cast<std::uint32_t>(value);
    bits = static_cast<std::uint16_t>((whole + 0x7fffU + (whole >> 16 & 1U)) >> 16);
  }
  constexpr explicit operator float() const { return std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16); }
};

/// IEEE 754 binary16: 11 bits of precision (relative rounding 2^-12), magnitudes to 65504, subnormal below 2^-14.
struct Float16 {
  std::uint16_t bits = 0;

  constexpr Float16() = default;
  /// Rounds to nearest, ties to even; infinity beyond 65504. Not for NaN.
  constexpr explicit(false) Float16(float value) {
    const auto whole = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = whole >> 16 & 0x8000U, magnitude = whole & 0x7fffffffU;
    std::uint32_t half;
    if (magnitude >= 0x477ff000U) {  // rounds to 65536 or more
      half = 0x7c00U;
    } else if (magnitude >= 0x38800000U) {  // normal: bias 127 -> 15, 23 -> 10 bits
      half = (magnitude - 0x38000000U + 0xfffU + (magnitude >> 13 & 1U)) >> 13;
    } else {  // subnormal, in units of 2^-24: adding 2^23 units rounds the rest away
      constexpr float kMagic = 0.5F;
      const float aligned = std::bit_cast<float>(magnitude) + kMagic;
      half = std::bit_cast<std::uint32_t>(aligned) - std::bit_cast<std::uint32_t>(kMagic);
    }
    bits = static_cast<std::uint16_t>(sign | half);
  }
  /// Converts exactly, subnormals included.
  constexpr explicit operator float() const {
    const auto sign = (static_cast<std::uint32_t>(bits) & 0x8000U) << 16;
    const auto shifted = std::bit_cast<float>((static_cast<std::uint32_t>(bits) & 0x7fffU) << 13);
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(shifted * 0x1p112F) | sign);
  }
};

template <>
struct ComputesIn<Bfloat16> {
  using Type = float;
};
template <>
struct ComputesIn<Float16> {
  using Type = float;
};

}  // namespace nlo::inline NLO_ISA

#if NLO_HAS_VECTORS
namespace nlo::inline NLO_ISA::kernels::native {
#define NLO_CODE NLO_INLINE
#define NLO_ISA_BYTES NLO_NATIVE_BYTES
#if defined(__F16C__) && NLO_NATIVE_BYTES >= 16
#define NLO_ISA_F16C 1
#else
#define NLO_ISA_F16C 0
#endif
#include "nlo/kernels/per_isa/half_weights.inc"
#undef NLO_ISA_F16C
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace nlo::inline NLO_ISA::kernels::native
#endif

#if defined(NLO_DISPATCHES)
namespace nlo::inline NLO_ISA::kernels::x86 {
#define NLO_ISA_F16C 1
namespace avx2 {
#define NLO_CODE NLO_CODE_AVX2
#define NLO_ISA_BYTES 32
#include "nlo/kernels/per_isa/half_weights.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace avx2

namespace avx512 {
#define NLO_CODE NLO_CODE_AVX512
#define NLO_ISA_BYTES 64
#include "nlo/kernels/per_isa/half_weights.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace avx512

namespace avx512_one_load {
#define NLO_CODE NLO_CODE_AVX512
#define NLO_ISA_BYTES 64
#include "nlo/kernels/per_isa/half_weights.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace avx512_one_load
#undef NLO_ISA_F16C
}  // namespace nlo::inline NLO_ISA::kernels::x86
#endif
