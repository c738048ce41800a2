// SPDX-License-Identifier: MIT
// The known equations of a plant, dx/dt = f(x, u) and y = h(x), by expressions: what an observer's prior is made of.
// One text for all who step them: in double and float, in lanes side by side, with derivatives, in intervals.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model/network.h"
#include "codegen/model/shared_expressions.h"

namespace nlo::codegen {

/// Over the names of the states, of the inputs and of the parameters.
struct EquationTexts {
  std::vector<std::string> derivative, outputs;  ///< n_x and n_y expressions
  std::vector<std::pair<std::string, double>> parameters = {};
};

/// x, no further than the states' range and a little: RK4 overflows from where no plant has been.
template <class Scalar>
Scalar kept_within(Scalar x, double low, double high) {
  const auto from = static_cast<Scalar>(low), to = static_cast<Scalar>(high);
  return x < from ? from : x > to ? to : x;
}
Interval kept_within(Interval x, double low, double high);

class Equations {
 public:
  static constexpr int kMostStates = 16, kMostInputs = 16, kMostOutputs = 16;

  Equations() = default;
  /// Throws Error, naming the equation and what is wrong with it.
  Equations(const EquationTexts& texts, const std::vector<Channel>& states, const std::vector<Channel>& inputs);

  int nx() const { return static_cast<int>(derivative_.rows.size()); }
  int ny() const { return static_cast<int>(output_.rows.size()); }
  /// Of what a step of RK4 and an output evaluate.
  int count(int (Expression::*of)() const) const;
  const SharedExpressions& derivative() const { return derivative_; }
  const SharedExpressions& output() const { return output_; }
  double parameter(int index) const { return parameters_[static_cast<std::size_t>(index)]; }
  /// What an expression reads as reading j is x[j], then u[j - n_x], then parameter(j - n_x - n_u), then the parts
  /// that they share.
  int first_input() const { return nx(); }
  int first_parameter() const { return nx() + nu_; }
  int first_part() const { return first_parameter() + static_cast<int>(parameters_.size()); }

  /// y (n_y) from x (n_x).
  template <class Value>
  void output(const Value* x, Value* y) const {
    output_.evaluate([&](int j) { return j < nx() ? x[j] : Value(parameter(j - first_parameter())); }, y);
  }

  /// dx (n_x) from x (n_x) and u (n_u).
  template <class Value>
  void derivative(const Value* x, const Value* u, Value* dx) const {
    const auto reading = [&](int j) {
      if (j < nx()) return x[j];
      return j < first_parameter() ? u[j - nx()] : Value(parameter(j - first_parameter()));
    };
    derivative_.evaluate(reading, dx);
  }

  /// x (n_x) `h` seconds on, in place, by one step of RK4.
  ///   inputs(c, u)  writes u (n_u) at the part c in [0, 1] of the step
  template <class Value, class Inputs>
  void step(Value* x, const Value& h, const Inputs& inputs) const {
    using State = std::array<Value, kMostStates>;
    State at, k, sum;
    std::array<Value, kMostInputs> u;
    const auto n = static_cast<std::size_t>(nx());
    constexpr std::array kParts = {0.0, 0.5, 0.5, 1.0}, kWeights = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
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
  int nu_ = 0;
  SharedExpressions derivative_, output_;
  std::vector<double> parameters_;
};

}  // namespace nlo::codegen
