// SPDX-License-Identifier: MIT
// What expressions are evaluated in: numbers, intervals of them, and parities; and the functions that they may name.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace nlo::codegen {

/// Of one argument, as nlo/functions.h has them.
enum class Function { kSine, kCosine, kTanh, kExponential, kLogarithm, kRoot, kArcTangent, kMagnitude, kSign };

struct FunctionRow {
  Function function;
  std::string_view name;     ///< in an expression
  std::string_view runtime;  ///< in C and C++
};
std::span<const FunctionRow> all_functions();
const FunctionRow& row_of(Function function);
/// Null: there is none of that name.
const FunctionRow* function_named(std::string_view name);
/// "sin, cos, ..."
std::string function_names();

double value_of(Function function, double x);
float value_of(Function function, float x);

template <class Value>
Value square(const Value& x) {
  return x * x;
}

/// All values that a quantity may have, rounded outwards (where no product underflows). Where it may have none, all
/// numbers and beyond: low = -inf, high = inf.
struct Interval {
  double low = 0.0, high = 0.0;

  Interval(double value = 0.0) : low(value), high(value) {}  // NOLINT: a number is an interval
  Interval(double from, double to) : low(from), high(to) {}
  static Interval any();
  bool bounded() const;
};
Interval operator+(Interval a, Interval b);
Interval operator-(Interval a, Interval b);
Interval operator*(Interval a, Interval b);
Interval operator/(Interval a, Interval b);
Interval square(Interval a);
Interval value_of(Function function, Interval x);

/// What becomes of a quantity when all that is odd changes its sign.
enum class Parity { kOdd, kEven, kNeither };

/// The parity of sums, products and functions.
struct WithParity {
  Parity parity;

  WithParity(double /*number*/ = 0.0) : parity(Parity::kEven) {}  // NOLINT: a number does not change
  WithParity(Parity of_reading) : parity(of_reading) {}           // NOLINT
};
WithParity operator+(WithParity a, WithParity b);
WithParity operator-(WithParity a, WithParity b);
WithParity operator*(WithParity a, WithParity b);
WithParity operator/(WithParity a, WithParity b);
WithParity value_of(Function function, WithParity x);

}  // namespace nlo::codegen
