// SPDX-License-Identifier: MIT
// Table of the activations of a network. A row has the name in model files, value, slope and curvature in double by the
// standard library, and the properties that other parts of the program need. No other code tests for a specific
// activation. A new one needs an enumerator in nlo/kernels/activation.h with its runtime function, and a row here. Code
// that does not support a row does not compile, or names the activation in its error.
#pragma once

#include <nlo/kernels/activation.h>
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "codegen/base/error.h"

namespace nlo::codegen {

/// Bound of the initial weights before an activation, which are drawn uniformly within +-bound.
enum class WeightBound {
  kGlorot,  ///< sqrt(6 / (fan_in + fan_out)), for a slope of 1 at 0
  kHe,      ///< sqrt(6 / fan_in), for activations that cut off half of the inputs
};

/// Turning points of a function of one variable. Its range over an interval follows from the two ends and these points.
struct TurningPoint {
  double at, value;
  double margin = 0.0;  ///< rounding error of `at`; `value` is rounded outwards
};

struct TurningPoints {
  std::array<TurningPoint, 2> points{};
  std::size_t count = 0;

  constexpr const TurningPoint* begin() const { return points.data(); }
  constexpr const TurningPoint* end() const { return points.data() + count; }
};

struct ActivationRow {
  Activation kind;
  std::string_view name;   ///< name in model files and experiments; for a coarser tanh, in FoldedNetwork::activation
  const char* identifier;  ///< name in C++
  Activation trained_as;   ///< `kind`; for an activation that only an export chooses: the activation that it replaces
  std::string_view int16_form;  ///< its int16 form in words, for the comment of a header; empty: none
  bool has_c99;                 ///< c99_map.cpp can write it
  WeightBound weight_bound;

  double (*value)(double v);
  double (*slope)(double v);      ///< relu at 0: 0
  double (*curvature)(double v);  ///< relu: 0 at 0 too

  bool slope_needs_input;  ///< the slope depends on the argument, not only on the value
  double largest_value;    ///< sup |value|; infinite: training records the largest values
  bool kink_at_zero;       ///< two straight pieces, convex, that meet in (0, 0); the slope has no derivative there

  TurningPoints value_turns;    ///< extrema of the value
  TurningPoints slope_turns;    ///< turning points of the slope; at a jump, both its sides
  double largest_curvature;     ///< sup of |value''| away from a kink
  double largest_slope_change;  ///< sup of |slope''| away from a kink

  constexpr bool is_trained() const { return trained_as == kind; }
  constexpr bool has_int16() const { return !int16_form.empty(); }
};

namespace activation_functions {
double tanh(double v);
double tanh_slope(double v);
double tanh_curvature(double v);
double relu(double v);
double relu_slope(double v);
double relu_curvature(double v);
double silu(double v);
double silu_slope(double v);
double silu_curvature(double v);
}  // namespace activation_functions

namespace activation_rows {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

constexpr ActivationRow tanh_row(Activation kind, std::string_view name, const char* identifier) {
  return {.kind = kind,
          .name = name,
          .identifier = identifier,
          .trained_as = Activation::kTanh,
          .int16_form = kind == Activation::kTanh ? "the argument of tanh, in Q16" : "",
          .has_c99 = kind == Activation::kTanh,
          .weight_bound = WeightBound::kGlorot,
          .value = activation_functions::tanh,
          .slope = activation_functions::tanh_slope,
          .curvature = activation_functions::tanh_curvature,
          .slope_needs_input = false,
          .largest_value = 1.0,
          .kink_at_zero = false,
          .value_turns = {},
          .slope_turns = {{{{0.0, 1.0}}}, 1},
          .largest_curvature = 0.8,  // 0.77
          .largest_slope_change = 2.0};
}

}  // namespace activation_rows

/// One row for each activation, in the order of the enumeration.
inline constexpr std::array kActivations = {
    activation_rows::tanh_row(Activation::kTanh, "tanh", "Activation::kTanh"),
    ActivationRow{.kind = Activation::kRelu,
                  .name = "relu",
                  .identifier = "Activation::kRelu",
                  .trained_as = Activation::kRelu,
                  .int16_form = "the result of relu",
                  .has_c99 = true,
                  .weight_bound = WeightBound::kHe,
                  .value = activation_functions::relu,
                  .slope = activation_functions::relu_slope,
                  .curvature = activation_functions::relu_curvature,
                  .slope_needs_input = false,  // a > 0 exactly where v > 0
                  .largest_value = activation_rows::kUnbounded,
                  .kink_at_zero = true,
                  .value_turns = {},
                  .slope_turns = {{{{0.0, 0.0}, {0.0, 1.0}}}, 2},
                  .largest_curvature = 0.0,
                  .largest_slope_change = 0.0},
    // silu falls to its minimum and rises from there. Its slope is odd about 1/2. It is largest at 2.39936 and smallest
    // at -2.39936.
    ActivationRow{.kind = Activation::kSilu,
                  .name = "silu",
                  .identifier = "Activation::kSilu",
                  .trained_as = Activation::kSilu,
                  .int16_form = "half the argument of silu, in Q16",
                  .has_c99 = true,
                  .weight_bound = WeightBound::kHe,
                  .value = activation_functions::silu,
                  .slope = activation_functions::silu_slope,
                  .curvature = activation_functions::silu_curvature,
                  .slope_needs_input = true,
                  .largest_value = activation_rows::kUnbounded,
                  .kink_at_zero = false,
                  .value_turns = {{{{-1.2784645, -0.2784646, 1e-4}}}, 1},
                  .slope_turns = {{{{2.39936, 1.09984, 1e-4}, {-2.39936, -0.09984, 1e-4}}}, 2},
                  .largest_curvature = 0.5,
                  .largest_slope_change = 0.5},  // 0.31
    activation_rows::tanh_row(Activation::kTanh5e6, "tanh5e6", "Activation::kTanh5e6"),
    activation_rows::tanh_row(Activation::kTanh5e5, "tanh5e5", "Activation::kTanh5e5"),
};

constexpr const ActivationRow& activation_row(Activation kind) {
  return kActivations[static_cast<std::size_t>(kind)];
}

/// Returns the row of a name in a model file or an experiment; null if there is none, or if only an export chooses it.
const ActivationRow* find_activation(std::string_view name);
/// Finds the row of a name. Throws Error for an unknown name: unknown activation "gelu"; use tanh, relu or silu.
const ActivationRow& activation_named(std::string_view name);

/// Names of the activations that a network may be trained with: tanh, relu, silu.
std::vector<std::string> activation_names();
/// Lists the names as text: "tanh, relu or silu".
std::string activations_in_words();

/// Returns the activation of each entry, in the precision of the array (float or double).
template <class Scalar>
using ActivationArray = Eigen::Array<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <class Scalar>
ActivationArray<Scalar> activated(Activation kind, const Eigen::Ref<const ActivationArray<Scalar>>& v);
/// Returns the slope of each entry, from v and a = activated(v).
template <class Scalar>
ActivationArray<Scalar> activation_slopes(Activation kind, const Eigen::Ref<const ActivationArray<Scalar>>& v,
                                          const Eigen::Ref<const ActivationArray<Scalar>>& a);

namespace activation_rows {

[[noreturn]] void refuse_untrained(Activation kind);

template <class Run>
using ResultOf = std::invoke_result_t<const Run&, std::integral_constant<Activation, kActivations[0].kind>>;

template <bool kAll, std::size_t kRow, class Run>
ResultOf<Run> run_from(Activation kind, const Run& run) {
  constexpr const ActivationRow& kThis = kActivations[kRow];
  if constexpr (kAll || kThis.is_trained()) {
    if (kind == kThis.kind) return run(std::integral_constant<Activation, kThis.kind>{});
  }
  if constexpr (kRow + 1 < kActivations.size()) {
    return run_from<kAll, kRow + 1>(kind, run);
  } else {
    refuse_untrained(kind);
  }
}

constexpr bool in_order() {
  for (std::size_t i = 0; i < kActivations.size(); ++i)
    if (static_cast<std::size_t>(kActivations[i].kind) != i) return false;
  return true;
}
static_assert(in_order(), "row i of kActivations is the enumerator with the value i");

}  // namespace activation_rows

/// Returns run(std::integral_constant<Activation, kind>{}), which turns a number into a template parameter. `run` is
/// instantiated for every row and returns the same type for each.
template <class Run>
auto with_activation(Activation kind, const Run& run) {
  return activation_rows::run_from<true, 0>(kind, run);
}

/// Calls `run` for an activation that can be trained. Throws Error for the others.
template <class Run>
auto with_trained_activation(Activation kind, const Run& run) {
  return activation_rows::run_from<false, 0>(kind, run);
}

}  // namespace nlo::codegen
