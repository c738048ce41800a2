// SPDX-License-Identifier: MIT
// Types in which expressions are evaluated (numbers, intervals, parities), and the functions that expressions may call.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace nlo::codegen {

/// Functions of one argument, see nlo/functions.h.
enum class Function { kSine, kCosine, kTanh, kExponential, kLogarithm, kRoot, kArcTangent, kMagnitude, kSign };

struct FunctionRow {
  Function function;
  std::string_view name;     ///< name in an expression
  std::string_view runtime;  ///< name in C and C++
};
std::span<const FunctionRow> all_functions();
const FunctionRow& row_of(Function function);
/// Returns the function of that name; null if there is none.
const FunctionRow* function_named(std::string_view name);
/// Returns "sin, cos, ...".
std::string function_names();

double value_of(Function function, double x);
float value_of(Function function, float x);

/// Returns the smaller and the larger of two numbers; NaN if either is NaN.
template <class Scalar>
Scalar minimum_of(Scalar a, Scalar b) {
  return a > b || b != b ? b : a;
}
template <class Scalar>
Scalar maximum_of(Scalar a, Scalar b) {
  return a < b || b != b ? b : a;
}

template <class Value>
Value square(const Value& x) {
  return x * x;
}

/// All values that a quantity may have, rounded outwards (unless a product underflows). If the quantity may be
/// undefined, low = -inf and high = inf.
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
Interval minimum_of(Interval a, Interval b);
Interval maximum_of(Interval a, Interval b);
Interval value_of(Function function, Interval x);

/// Behaviour of a quantity when all odd quantities change their sign.
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
WithParity minimum_of(WithParity a, WithParity b);
WithParity maximum_of(WithParity a, WithParity b);
WithParity value_of(Function function, WithParity x);

}  // namespace nlo::codegen
