// SPDX-License-Identifier: MIT
// Gated units (gated_observer.h) in int16, for cores without an FPU. They need half the flash of float. A step:
//   q      = [z; saturate((y - centre) gain)]                     Q15
//   [s; g] = (1 + tanh(gates(q))) / 2,   c = tanh(candidate([g z; q_y]))       by the table of int16.h, Q15
//   z+     = z + s (c - z)                                        s and c - z in Q15, z in Q23
// z is stored in a float, exactly: a multiple of 2^-23 within +-32767/32768. The code around the units is therefore the
// same as in float. The error of s is up to 1e-4, the error of the table. A unit with a smaller s moves too fast or not
// at all. `nlo export --scalar int16` writes it. Its bits are the same on every target and for both arithmetic
// policies.
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/gate.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/int16.h"
#include "nlo/quantised_map.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA::kernels::int16 {

inline constexpr int kLatentBits = 23, kBelowQ15 = kLatentBits - 15;
inline constexpr std::uint32_t kLatentExponent = std::uint32_t{kLatentBits}
                                                 << 23;  ///< multiplies a float by 2^23 if added to its bits

/// Returns 2^23 z, rounded towards zero; z is limited to +-32767/32768.
NLO_INLINE constexpr std::int32_t integer_latent(float z) {
  const auto bits = std::bit_cast<std::uint32_t>(z);
  if (!is_below(z, static_cast<float>(kOne) / (kOne + 1))) [[unlikely]]
    return (bits >> 31 != 0 ? -kOne : kOne) * (1 << kBelowQ15);
  return static_cast<std::int32_t>(std::bit_cast<float>(bits + kLatentExponent));
}

/// Returns 2^-23 z, exactly. A product would take 60 instructions of libgcc on cores without an FPU.
NLO_INLINE constexpr float float_latent(std::int32_t z) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(z));
  return std::bit_cast<float>(bits - (kLatentExponent & (0U - static_cast<std::uint32_t>(z != 0))));
}

/// Returns the fraction of the distance to its target that a unit covers in a step of `periods` sample periods, in Q15.
///   argument  argument of its gate, in Q16
inline std::int32_t share_over(std::int32_t argument, float periods) {
  return static_cast<std::int32_t>(
      rounded(gate_over(rounded(static_cast<float>(argument) * 0x1p-16F), periods) * 32767.0F));
}

/// Returns latent + share (target - latent). latent: Q23; share, target: Q15. No product overflows:
/// 32767 * 65534 < 2^31 - 64.
NLO_INLINE constexpr std::int32_t moved(std::int32_t latent, std::int32_t share, std::int32_t target) {
  constexpr int kShift = 30 - kLatentBits;
  return latent + ((share * (target - (latent >> kBelowQ15)) + (1 << (kShift - 1))) >> kShift);
}

}  // namespace nlo::inline NLO_ISA::kernels::int16

namespace nlo::inline NLO_ISA {

/// Gates of a GatedModel that reads kReadings readings; with kReadings = 0 its candidate. Mlp_: a QuantisedMlp of one
/// layer, whose sums / 2^shift are the argument of the tanh in Q16.
template <class Mlp_, int kReadings = 0>
struct QuantisedUnits {
  using Scalar = float;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  float centre[kReadings];
  float gain[kReadings];  ///< 32767 / (half of the range of the reading)
  Mlp_ mlp;

  /// Advances z by `periods` sample periods with the readings y at the end. kRegular: by one period.
  template <bool kRegular, class Candidate, int kNz>
  void step(const Candidate& candidate, float (&z)[kNz], const float (&y)[kReadings], float periods) const {
    namespace q = kernels::int16;
    static_assert(kIn == kNz + kReadings && kOut == 2 * kNz);
    alignas(4) std::int16_t in[2 * q::kPairs<kIn>];
    std::int16_t gate[2 * kNz + 1];           // tanh(a_s), then tanh(a_g)
    std::int16_t* const target = gate + kNz;  // overwrites tanh(a_g), which is not needed any more by then
    if constexpr (kIn % 2 != 0) in[kIn] = 0;
    for (int r = 0; r < kNz; ++r) in[r] = static_cast<std::int16_t>(q::integer_latent(z[r]) >> q::kBelowQ15);
    for (int j = 0; j < kReadings; ++j) in[kNz + j] = q::quantised(y[j] - centre[j], gain[j]);
    if constexpr (kRegular) {
      quantised_layer<Activation::kTanh>(mlp.layer, in, gate);
    } else {
      q::layer<kIn, kOut>(mlp.layer.weights, mlp.layer.bias, in, [&](int o, std::int32_t sum) {
        const std::int32_t argument = q::shifted_and_saturated<20, decltype(mlp.layer)::kShift>(sum);
        const std::int32_t value =
            o < kNz ? 2 * q::share_over(argument, periods) - (q::kOne + 1) : q::tanh_q15(argument);
        if (o < kOut) gate[o] = static_cast<std::int16_t>(value);
      });
    }
    for (int r = 0; r < kNz; ++r) in[r] = static_cast<std::int16_t>((in[r] * (q::kOne + 1 + gate[kNz + r])) >> 16);
    quantised_layer<Activation::kTanh>(candidate.mlp.layer, in, target);
    for (int r = 0; r < kNz; ++r) {
      if (!is_below(z[r], 0x1p100F)) [[unlikely]]
        continue;  // a bit flip corrupted z; the observer detects it
      z[r] = q::float_latent(q::moved(q::integer_latent(z[r]), (q::kOne + 1 + gate[r]) >> 1, target[r]));
    }
  }
};

/// The candidate of a GatedModel.
template <class Mlp_>
struct QuantisedUnits<Mlp_, 0> {
  using Scalar = float;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  Mlp_ mlp;
};

}  // namespace nlo::inline NLO_ISA
