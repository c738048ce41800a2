// SPDX-License-Identifier: MIT
// The known equations of a plant, dx/dt = f(x, u) and y = h(x, u), by expressions, from which an observer's prior is
// made. The same text is evaluated in all arithmetics: double, float, lanes side by side
// (trainer/structures/equation_tape.h), and intervals.
#pragma once

#include <nlo/covariance.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model/network.h"
#include "codegen/model/shared_expressions.h"

namespace nlo::codegen {

/// Expressions over the names of the states, the inputs and the parameters.
struct EquationTexts {
  std::vector<std::string> derivative, outputs;  ///< one expression for each state, n_y expressions
  std::vector<std::pair<std::string, double>> parameters = {};
  /// States of the plant that are not estimated; they follow the estimated states.
  std::vector<std::string> unestimated = {};
};

/// Returns x, limited to the states' range plus a margin, because RK4 may overflow from states that no plant has.
template <class Scalar>
Scalar kept_within(Scalar x, double low, double high) {
  const auto from = static_cast<Scalar>(low), to = static_cast<Scalar>(high);
  return x < from ? from : x > to ? to : x;
}
Interval kept_within(Interval x, double low, double high);

/// The plant's equations together with the equation of an extended Kalman filter for the covariance P of x between
/// measurements,
///   dP/dt = F P + P F',  F = df/dx,
/// integrated as one state [x; p], where p is the upper triangle of P row by row. It also has the slopes dh/dx of the
/// outputs.
class Equations {
 public:
  static constexpr int kMostStates = 16, kMostInputs = 16, kMostOutputs = 16;
  static constexpr int kMostCarried = kMostStates + triangle_size(kMostStates);

  Equations() = default;
  /// Throws Error with the equation and the reason.
  Equations(const EquationTexts& texts, const std::vector<Channel>& states, const std::vector<Channel>& inputs);

  int nx() const { return nx_; }
  int ny() const { return ny_; }
  int carried() const { return nx_ + triangle_size(nx_); }                ///< size of [x; p]
  int place(int i, int j) const { return nx_ + in_triangle(nx_, i, j); }  ///< place of P's element in [x; p]
  /// Returns the number of operations of every expression that a step of RK4 and an output evaluate.
  int count(int (Expression::*of)() const) const;
  const SharedExpressions& derivative() const { return derivative_; }
  const SharedExpressions& output() const { return output_; }
  double parameter(int index) const { return parameters_[static_cast<std::size_t>(index)]; }
  /// The readings of an expression are [x; p], then u, then the parameters, then the sub-expressions that expressions
  /// share.
  int first_input() const { return carried(); }
  int first_parameter() const { return carried() + nu_; }
  int first_part() const { return first_parameter() + static_cast<int>(parameters_.size()); }

  /// Returns true if an output depends on an input.
  bool outputs_read_inputs() const;

  /// Computes y (n_y), then the slopes dh/dx (n_y x n_x) row by row, from x (n_x) and u (n_u).
  template <class Value>
  void output(const Value* x, const Value* u, Value* y) const {
    output_.evaluate(readings<Value>(x, u), y);
  }
  /// Computes d[x; p]/dt from [x; p] and u (n_u).
  template <class Value>
  void derivative(const Value* x, const Value* u, Value* dx) const {
    derivative_.evaluate(readings<Value>(x, u), dx);
  }

  /// The positions in a step at which RK4 evaluates the equations, and the weights of their values.
  static constexpr std::array kParts = {0.0, 0.5, 0.5, 1.0}, kWeights = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};

  /// Advances [x; p] by `h` seconds, in place, by one step of RK4.
  ///   inputs(c, u)  writes u (n_u) at the part c in [0, 1] of the step
  template <class Value, class Inputs>
  void step(Value* x, const Value& h, const Inputs& inputs) const {
    std::array<Value, kMostCarried> at, k, sum;
    std::array<Value, kMostInputs> u;
    const auto n = static_cast<std::size_t>(carried());
    for (std::size_t i = 0; i < kParts.size(); ++i) {
      for (std::size_t r = 0; r < n; ++r) at[r] = i == 0 ? x[r] : x[r] + h * (Value(kParts[i]) * k[r]);
      inputs(kParts[i], u.data());
      derivative(at.data(), u.data(), k.data());
      for (std::size_t r = 0; r < n; ++r) {
        const Value part = Value(kWeights[i]) * k[r];
        sum[r] = i == 0 ? part : sum[r] + part;
      }
    }
    for (std::size_t r = 0; r < n; ++r) x[r] = x[r] + h * sum[r];
  }

 private:
  static constexpr std::size_t kMostParameters = 64;

  /// Appends the rows of dP/dt after f.
  void append_covariance(std::vector<Expression>& derivative) const;

  template <class Value>
  auto readings(const Value* x, const Value* u) const {
    return [this, x, u](int j) {
      if (j < first_input()) return x[j];
      return j < first_parameter() ? u[j - first_input()] : Value(parameter(j - first_parameter()));
    };
  }

  int nx_ = 0, ny_ = 0, nu_ = 0;
  SharedExpressions derivative_, output_;
  std::vector<double> parameters_;
};

/// Checks that y, dx/dt, their slopes and a piece of an RK4 step stay far below the largest float32 for every x and u
/// within the given intervals. RK4 also evaluates the equations at middle points, which may be outside the intervals.
/// Quotients and functions may be unbounded there: in flight such a value is NaN, and the observer resets.
///   x  carried() intervals, the limits of [x; p];  u  n_u intervals
/// Throws Error with the equation and the remedy.
void check_bounded(const Equations& equations, std::vector<Interval> x, const std::vector<Interval>& u,
                   double sample_period_s);

}  // namespace nlo::codegen
