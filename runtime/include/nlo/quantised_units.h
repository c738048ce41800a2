// SPDX-License-Identifier: MIT
// Gated units (gated_observer.h) in int16, for cores without an FPU and for half the flash. A step in integers:
//   q      = [z; saturate((y - centre) gain)]                     Q15
//   [s; g] = (1 + tanh(gates(q))) / 2,   c = tanh(candidate([g z; q_y]))       by the table of int16.h, Q15
//   z+     = z + s (c - z)                                        s and c - z in Q15, z in Q23
// z stands in a float, exactly: a multiple of 2^-23 within +-32767/32768, so that all around the units stays as it is.
// s is within 1e-4, as the table is: a unit that goes less than that of its way in a step goes too fast, or not at all.
// `nlo export --scalar int16` writes it. The same bits on every target, whatever the arithmetic policy.
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/gate.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/int16.h"
#include "nlo/quantised_map.h"
#include "nlo/vector.h"

namespace nlo::kernels::int16 {

inline constexpr int kLatentBits = 23, kBelowQ15 = kLatentBits - 15;
inline constexpr std::uint32_t kLatentExponent = std::uint32_t{kLatentBits}
                                                 << 23;  ///< 2^23 as float counts powers of 2

/// z 2^23, towards zero; beyond +-32767/32768 the end.
NLO_INLINE constexpr std::int32_t integer_latent(float z) {
  const auto bits = std::bit_cast<std::uint32_t>(z);
  if (!is_below(z, static_cast<float>(kOne) / (kOne + 1))) [[unlikely]]
    return (bits >> 31 != 0 ? -kOne : kOne) * (1 << kBelowQ15);
  return static_cast<std::int32_t>(std::bit_cast<float>(bits + kLatentExponent));
}

/// The float of an integer latent, exactly. No product: libgcc takes 60 instructions for one on cores without an FPU.
NLO_INLINE constexpr float float_latent(std::int32_t z) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(z));
  return std::bit_cast<float>(bits - (kLatentExponent & (0U - static_cast<std::uint32_t>(z != 0))));
}

/// The share of its way that a unit goes over so many sample periods, in Q15, of its gate's argument in Q16.
inline std::int32_t share_over(std::int32_t argument, float periods) {
  return static_cast<std::int32_t>(
      rounded(gate_over(rounded(static_cast<float>(argument) * 0x1p-16F), periods) * 32767.0F));
}

/// An integer latent and that share of its way to `target`, in Q15. No product overflows: 32767 65534 < 2^31 - 64.
NLO_INLINE constexpr std::int32_t moved(std::int32_t latent, std::int32_t share, std::int32_t target) {
  constexpr int kShift = 30 - kLatentBits;
  return latent + ((share * (target - (latent >> kBelowQ15)) + (1 << (kShift - 1))) >> kShift);
}

}  // namespace nlo::kernels::int16

namespace nlo {

/// Gates of a GatedModel with kReadings readings beside z, or without them its candidate. Mlp_: a QuantisedMlp of one
/// layer, whose sums / 2^shift are tanh's argument in Q16.
template <class Mlp_, int kReadings = 0>
struct QuantisedUnits {
  using Scalar = float;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  float centre[kReadings];
  float gain[kReadings];  ///< 32767 / half of the reading's range
  Mlp_ mlp;

  /// z one step of so many sample periods on, with the readings y at its end. kRegular: of one period.
  template <bool kRegular, class Candidate, int kNz>
  void step(const Candidate& candidate, float (&z)[kNz], const float (&y)[kReadings], float periods) const {
    namespace q = kernels::int16;
    static_assert(kIn == kNz + kReadings && kOut == 2 * kNz);
    alignas(4) std::int16_t in[2 * q::kPairs<kIn>];
    std::int16_t gate[2 * kNz + 1];           // tanh(a_s), then tanh(a_g)
    std::int16_t* const target = gate + kNz;  // once those are multiplied; an odd number has a zero behind it
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
        continue;  // a bit has flipped: the observer shall see it
      z[r] = q::float_latent(q::moved(q::integer_latent(z[r]), (q::kOne + 1 + gate[r]) >> 1, target[r]));
    }
  }
};

/// A candidate.
template <class Mlp_>
struct QuantisedUnits<Mlp_, 0> {
  using Scalar = float;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  Mlp_ mlp;
};

}  // namespace nlo
