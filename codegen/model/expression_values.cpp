// SPDX-License-Identifier: MIT
#include "codegen/model/expression_values.h"

#include <nlo/functions.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/fail.h"

namespace nlo::codegen {
namespace {

constexpr std::array kFunctions = {FunctionRow{Function::kSine, "sin", "sine"},
                                   FunctionRow{Function::kCosine, "cos", "cosine"},
                                   FunctionRow{Function::kTanh, "tanh", "hyperbolic_tangent"},
                                   FunctionRow{Function::kExponential, "exp", "exponential"},
                                   FunctionRow{Function::kLogarithm, "ln", "logarithm"},
                                   FunctionRow{Function::kRoot, "sqrt", "square_root"},
                                   FunctionRow{Function::kArcTangent, "atan", "arc_tangent"},
                                   FunctionRow{Function::kMagnitude, "abs", "magnitude"},
                                   FunctionRow{Function::kSign, "sign", "sign_of"}};

template <class Scalar>
Scalar number_of(Function function, Scalar x) {
  switch (function) {
    case Function::kSine:
      return std::sin(x);
    case Function::kCosine:
      return std::cos(x);
    case Function::kTanh:
      return std::tanh(x);
    case Function::kExponential:
      return std::exp(x);
    case Function::kLogarithm:
      return std::log(x);
    case Function::kRoot:
      return std::sqrt(x);
    case Function::kArcTangent:
      return std::atan(x);
    case Function::kMagnitude:
      return std::abs(x);
    default:
      return x > 0 ? Scalar(1) : x < 0 ? Scalar(-1) : x;
  }
}

/// Widens an interval by more than the errors of rounding and of the standard library (assumed to be within 4 units in
/// the last place). A value of 0 does not change.
Interval outwards(double low, double high, double units = 1.0) {
  const double by = units * std::numeric_limits<double>::epsilon();
  return {low - by * std::abs(low), high + by * std::abs(high)};
}
constexpr double kLibraryUnits = 4.0;

/// Returns cos over an interval: 1 at whole turns, -1 half a turn further.
Interval cosine_of(Interval x) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const auto has = [&](double at) { return std::floor((x.high - at) / kTurn) >= std::ceil((x.low - at) / kTurn); };
  const auto [low, high] = std::minmax({std::cos(x.low), std::cos(x.high)});
  const Interval ends = outwards(low, high, kLibraryUnits);
  return {has(0.5 * kTurn) ? -1.0 : std::max(-1.0, ends.low), has(0.0) ? 1.0 : std::min(1.0, ends.high)};
}

}  // namespace

std::span<const FunctionRow> all_functions() {
  return kFunctions;
}

const FunctionRow& row_of(Function function) {
  return kFunctions[static_cast<std::size_t>(function)];
}

const FunctionRow* function_named(std::string_view name) {
  const auto found = std::ranges::find(kFunctions, name, &FunctionRow::name);
  return found == kFunctions.end() ? nullptr : &*found;
}

std::string function_names() {
  std::string names;
  for (const FunctionRow& row : kFunctions) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

double value_of(Function function, double x) {
  return number_of(function, x);
}
float value_of(Function function, float x) {
  return number_of(function, x);
}

Interval Interval::any() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {-kInfinity, kInfinity};
}
bool Interval::bounded() const {
  return std::isfinite(low) && std::isfinite(high);
}

Interval operator+(Interval a, Interval b) {
  return outwards(a.low + b.low, a.high + b.high);
}
Interval operator-(Interval a, Interval b) {
  return outwards(a.low - b.high, a.high - b.low);
}
Interval operator*(Interval a, Interval b) {
  if (!a.bounded() || !b.bounded()) return Interval::any();
  const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
  return outwards(low, high);
}
Interval operator/(Interval a, Interval b) {
  if (b.low <= 0.0 && b.high >= 0.0) return Interval::any();
  return a * outwards(1.0 / b.high, 1.0 / b.low);
}
Interval square(Interval a) {
  const auto [low, high] = std::minmax({a.low * a.low, a.high * a.high});
  const Interval ends = outwards(low, high);
  return {a.low < 0.0 && a.high > 0.0 ? 0.0 : ends.low, ends.high};
}

Interval minimum_of(Interval a, Interval b) {
  if (!a.bounded() || !b.bounded()) return Interval::any();
  return {std::min(a.low, b.low), std::min(a.high, b.high)};
}
Interval maximum_of(Interval a, Interval b) {
  if (!a.bounded() || !b.bounded()) return Interval::any();
  return {std::max(a.low, b.low), std::max(a.high, b.high)};
}

Interval value_of(Function function, Interval x) {
  const auto rising = [&] { return outwards(number_of(function, x.low), number_of(function, x.high), kLibraryUnits); };
  // Arguments for which the runtime's functions are defined.
  const auto within = [&](double low, double high) { return x.low > low && x.high < high; };
  constexpr auto kFarthestAngle = static_cast<double>(CircleFit<float>::kFarthest);
  constexpr auto kSmallest = static_cast<double>(std::numeric_limits<float>::min());
  constexpr auto kLargest = static_cast<double>(std::numeric_limits<float>::max());
  constexpr double kFarthestPower = 80.0;
  switch (function) {
    case Function::kSine:
      x = x - outwards(0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
      [[fallthrough]];
    case Function::kCosine:
      return within(-kFarthestAngle, kFarthestAngle) ? cosine_of(x) : Interval::any();
    case Function::kExponential:
      return within(-std::numeric_limits<double>::infinity(), kFarthestPower) ? rising() : Interval::any();
    case Function::kLogarithm:
      return within(kSmallest, kLargest) ? rising() : Interval::any();
    case Function::kRoot:
      return x.low >= 0.0 && x.high < kLargest ? rising() : Interval::any();
    case Function::kMagnitude: {
      const auto [low, high] = std::minmax({std::abs(x.low), std::abs(x.high)});
      return {x.low < 0.0 && x.high > 0.0 ? 0.0 : low, high};
    }
    default:
      return rising();
  }
}

WithParity operator+(WithParity a, WithParity b) {
  return a.parity == b.parity ? a : WithParity(Parity::kNeither);
}
WithParity operator-(WithParity a, WithParity b) {
  return a + b;
}
WithParity operator*(WithParity a, WithParity b) {
  if (a.parity == Parity::kNeither || b.parity == Parity::kNeither) return Parity::kNeither;
  return a.parity == b.parity ? Parity::kEven : Parity::kOdd;
}
WithParity operator/(WithParity a, WithParity b) {
  return a * b;
}
WithParity minimum_of(WithParity a, WithParity b) {
  return a.parity == Parity::kEven && b.parity == Parity::kEven ? a : WithParity(Parity::kNeither);
}
WithParity maximum_of(WithParity a, WithParity b) {
  return minimum_of(a, b);
}
WithParity value_of(Function function, WithParity x) {
  if (x.parity != Parity::kOdd) return x;
  switch (function) {
    case Function::kSine:
    case Function::kTanh:
    case Function::kArcTangent:
    case Function::kSign:
      return Parity::kOdd;
    case Function::kCosine:
    case Function::kMagnitude:
      return Parity::kEven;
    default:
      return Parity::kNeither;
  }
}

}  // namespace nlo::codegen
