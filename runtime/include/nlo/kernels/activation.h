// SPDX-License-Identifier: MIT
// Activations for scalars and SIMD packs, without libm. The trainer differentiates exactly the functions that the
// target executes. jvp.h has their slopes.
#pragma once

#include <cstdint>
#include <type_traits>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

namespace nlo {

/// Activation after every layer but the last. In float there are three fits of tanh with decreasing accuracy and cost;
/// `nlo export` chooses one by its error budget. In double, kTanh has the accuracy of a double.
enum class Activation : std::uint8_t {
  kTanh,  ///< within kTanhMaxError of tanh in float, kTanhMaxErrorDouble in double
  kRelu,
  kSilu,     ///< v sigmoid(v), computed by kTanh
  kTanh5e6,  ///< within 5e-6
  kTanh5e5,  ///< within 5e-5
};

}  // namespace nlo

namespace nlo::inline NLO_ISA {

constexpr bool is_tanh(Activation kind) {
  return kind == Activation::kTanh || kind == Activation::kTanh5e6 || kind == Activation::kTanh5e5;
}

/// tanh(x) ~ x P(x^2) / Q(x^2) with x clamped to +-limit; coefficients from the constant term up.
/// Minimax fits on [0, limit] of the absolute error (float) or the relative error (double). If the constant term of P
/// is 1, a small x is returned unchanged. All coefficients are positive, so that no sum cancels.
template <class Scalar, int kDegree>
struct TanhFit {
  static constexpr int kTerms = kDegree + 1;
  Scalar limit;
  Scalar p[kTerms];
  Scalar q[kTerms];
};
template <Activation kKind, class Scalar>
inline constexpr auto kTanhFit = [] {
  static_assert(is_tanh(kKind) || kKind == Activation::kSilu);
  constexpr auto c = [](double value) { return static_cast<Scalar>(value); };
  if constexpr (kKind == Activation::kTanh5e5) {  // largest error 4.4e-5
    return TanhFit<Scalar, 2>{
        c(5.02), {c(0.999805986), c(0.101655943), c(0.000652992555)}, {c(1.0), c(0.434426383), c(0.0126192799)}};
  } else if constexpr (kKind == Activation::kTanh5e6) {  // largest error 9.2e-7; 1.2e-6 when evaluated in float32
    return TanhFit<Scalar, 3>{c(6.9),
                              {c(1.0), c(0.123340328), c(0.00230391135), c(4.04847372e-06)},
                              {c(1.0), c(0.456667572), c(0.0212016298), c(0.000145175769)}};
  } else if constexpr (std::is_same_v<Scalar, double>) {  // largest error 2.3e-17; 8e-16 when evaluated in double
    return TanhFit<double, 9>{18.0,
                              {1.0, 0.15193175015422670, 0.0059936270507463660, 9.4317530935725272e-05,
                               6.9336628761145076e-07, 2.5057702651240713e-09, 4.3545167944911964e-12,
                               3.2739204315678736e-15, 8.1732472124386317e-19, 2.8696414640899893e-23},
                              {1.0, 0.48526508348755984, 0.034415321546600140, 0.00083233421638127333,
                               8.8492969623671302e-06, 4.5539107397220544e-08, 1.1495547113002910e-10,
                               1.3406402526870540e-13, 6.1062260721461662e-17, 6.9909645743305096e-21}};
  } else {  // largest error 4.1e-9; 3.7e-8 with rounded coefficients; 4.2e-7 in float32
    return TanhFit<Scalar, 4>{c(7.75),
                              {c(1.0), c(0.134537607), c(0.00358292833), c(2.20985712e-05), c(1.55599142e-08)},
                              {c(1.0), c(0.467870831), c(0.0262066592), c(0.000343050633), c(8.646428e-07)}};
  }
}();

/// Largest |tanh_rational(x) - tanh(x)| over every float32 x, infinities included.
inline constexpr double kTanhMaxError = 5e-7, kTanh5e6MaxError = 5e-6, kTanh5e5MaxError = 5e-5;
/// Largest error of kTanh over doubles.
inline constexpr double kTanhMaxErrorDouble = 1e-15;

inline namespace native {
using simd::larger;
using simd::smaller;
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/activations.inc"
#undef NLO_CODE
}  // namespace native

}  // namespace nlo::inline NLO_ISA
