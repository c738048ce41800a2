// SPDX-License-Identifier: MIT
// Error head: a second output of T* that gives the standard deviation sigma of each state's error. It reads the last
// hidden layer h of T*:
//   log2 sigma = W [h; h^2] + b,  limited to [lowest, highest]
// The squares are needed for odd plants, where h changes its sign with z but the size of the error does not change.
// Outside of the domain, and while the observer is stale, the error is unknown. Then sigma is kUnknownSigma, which is
// larger than any error.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "nlo/estimate_with_error.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp.h"

namespace nlo::inline NLO_ISA {

/// Coefficients of the exponential series. The first omitted term is below the rounding of 1 for |f| <= log(2) / 2.
template <class Scalar, int kTerms = sizeof(Scalar) == 4 ? 8 : 14>
struct ExpSeries {
  Scalar inverse_factorial[kTerms];

  constexpr ExpSeries() : inverse_factorial{} {
    double factorial = 1.0;
    for (int k = 0; k < kTerms; ++k) {
      if (k > 0) factorial *= k;
      inverse_factorial[k] = static_cast<Scalar>(1.0 / factorial);
    }
  }
  template <Arithmetic kArithmetic>
  constexpr Scalar operator()(Scalar f) const {
    return estrin<kArithmetic, 0, kTerms>(f, inverse_factorial);
  }
};

/// Returns 2^v for |v| <= 100; relative error below 2e-7 in float, 5e-16 in double.
template <Arithmetic kArithmetic = Arithmetic::kFast, class Scalar>
constexpr Scalar power_of_2(Scalar v) {
  constexpr ExpSeries<Scalar> kSeries;
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;
  constexpr int kFraction = std::numeric_limits<Scalar>::digits - 1;
  // The last bit of this number is worth 1. Adding v therefore rounds v to an integer, which stands in the last bits.
  constexpr Scalar kRounding = Scalar(3) * static_cast<Scalar>(Bits{1} << (kFraction - 1));
  const Scalar shifted = v + kRounding;
  const Scalar f = (v - (shifted - kRounding)) * static_cast<Scalar>(0.69314718055994530942);
  const Bits exponent = std::bit_cast<Bits>(shifted) << kFraction;
  const Scalar scale = std::bit_cast<Scalar>(exponent + std::bit_cast<Bits>(Scalar(1)));
  return kSeries.template operator()<kArithmetic>(f) * scale;
}

/// Error head of a T* whose last hidden layer has kWidth values.
template <class Scalar_, int kWidth_, int kNx_>
struct ErrorHead {
  using Scalar = Scalar_;
  static constexpr int kWidth = kWidth_;
  static constexpr int kNx = kNx_;
  PackedDense<Scalar, 2 * kWidth, kNx> layer;  ///< [h; h^2] to log2 sigma
  Scalar lowest[kNx];                          ///< range of log2 sigma in training; |.| <= 100
  Scalar highest[kNx];
  Scalar bound_95[kNx];  ///< half width of the 95 % interval, in sigmas

  struct OneLayer {  ///< the layer as a network
    static constexpr int kLayers = 1;
    const PackedDense<Scalar, 2 * kWidth, kNx>& layer;
  };

  /// out = mlp(in). Also computes log2_sigma, n_x, not limited to its range yet.
  template <Arithmetic kArithmetic, class Mlp>
  void evaluate(const Mlp& mlp, const Scalar* in, Scalar* out, Scalar* log2_sigma) const {
    static_assert(kWidth == Mlp::kHidden && kNx == Mlp::kOut, "it reads the last hidden layer");
    LayerBuffer<Scalar, (2 * kWidth > Mlp::kWidest ? 2 * kWidth : Mlp::kWidest)> hidden;
    LayerBuffer<Scalar, Mlp::kWidest> other;
    LayerBuffer<Scalar, kernels::kPadsInputs<Mlp::kIn> ? Mlp::kIn : 1> inputs;
    constexpr bool kPing = Mlp::kLayers % 2 == 0;  // layers write to ping and pong in turn; h must end in `hidden`
    kernels::evaluate<Mlp::kActivation, kArithmetic>(mlp, padded_inputs<Mlp::kIn>(in, inputs), out,
                                                     kPing ? hidden.values : other.values,
                                                     kPing ? other.values : hidden.values);
    evaluate<kArithmetic>(hidden.values, log2_sigma);
  }

  /// Computes log2_sigma, n_x, from h. `h` is a LayerBuffer of 2 kWidth values; h^2 is written to its second half.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(Scalar* h, Scalar* log2_sigma) const {
    for (int i = 0; i < kWidth; ++i) h[kWidth + i] = h[i] * h[i];
    for (int i = 2 * kWidth; i < kernels::padded(2 * kWidth); ++i) h[i] = Scalar(0);
    kernels::evaluate<Activation::kTanh, kArithmetic>(OneLayer{layer}, h, log2_sigma, h, h);
  }

  /// Returns sigma of state i, or kUnknownSigma if nothing is known of the error (known = false). If log2_sigma is NaN,
  /// sigma is the largest value that training has seen.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  constexpr Scalar deviation(int i, Scalar log2_sigma, bool known) const {
    const Scalar low = select<kArithmetic>(log2_sigma > lowest[i], log2_sigma, lowest[i]);
    const Scalar held = select<kArithmetic>(log2_sigma < highest[i], low, highest[i]);
    return select<kArithmetic>(known, power_of_2<kArithmetic>(held), Scalar(kUnknownSigma));
  }

  /// Returns x_hat at z and y with its intervals. known: z lies in the domain, and no reading is stale.
  template <Arithmetic kArithmetic, class Model, int kNz, int kNr>
  EstimateWithError<Scalar, kNx> estimate(const Model& model, const Scalar (&z)[kNz], const Scalar (&y)[kNr],
                                          bool known) const {
    EstimateWithError<Scalar, kNx> estimated;
    Scalar log2_sigma[kNx];
    if constexpr (kArithmetic == Arithmetic::kFast) {
      model.estimate(z, y, estimated.x_hat.values, &log2_sigma[0]);
    } else {
      model.template estimate<kArithmetic>(z, y, estimated.x_hat.values, &log2_sigma[0]);
    }
    for (int i = 0; i < kNx; ++i) {
      estimated.sigma[i] = deviation<kArithmetic>(i, log2_sigma[i], known);
      estimated.bound_95[i] = estimated.sigma[i] * bound_95[i];
    }
    return estimated;
  }
};

}  // namespace nlo::inline NLO_ISA
