// SPDX-License-Identifier: MIT
// The known equations of a plant, dx/dt = f(x, u) and y = h(x), by expressions: what an observer's prior is made of.
// One text for all who step them: in double and float, in lanes side by side, with derivatives, in intervals.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model/expression.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

/// Over the names of the states, of the inputs and of the parameters.
struct EquationTexts {
  std::vector<std::string> derivative, outputs;  ///< n_x and n_y expressions
  std::vector<std::pair<std::string, double>> parameters = {};
};

/// x, no further than the states' range and a little: RK4 of a polynomial overflows from where no plant has been.
template <class Scalar>
Scalar kept_within(Scalar x, double low, double high) {
  const auto from = static_cast<Scalar>(low), to = static_cast<Scalar>(high);
  return x < from ? from : x > to ? to : x;
}
Interval kept_within(Interval x, double low, double high);

class Equations {
 public:
  static constexpr int kMostStates = 16, kMostInputs = 16;

  Equations() = default;
  /// Throws Error, naming the equation and what is wrong with it.
  Equations(const EquationTexts& texts, const std::vector<Channel>& states, const std::vector<Channel>& inputs);

  int nx() const { return static_cast<int>(derivative_.size()); }
  int ny() const { return static_cast<int>(output_.size()); }
  const std::vector<Expression>& derivative() const { return derivative_; }
  const std::vector<Expression>& output() const { return output_; }
  double parameter(int index) const { return parameters_[static_cast<std::size_t>(index)]; }
  /// What an expression reads as reading j is x[j], then u[j - n_x], then parameter(j - n_x - n_u).
  int first_input() const { return nx(); }
  int first_parameter() const { return nx() + nu_; }

  template <class Value>
  Value output(int j, const Value* x) const {
    return value_of(output_[static_cast<std::size_t>(j)], x, static_cast<const Value*>(nullptr));
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
      for (std::size_t r = 0; r < n; ++r) k[r] = value_of(derivative_[r], at.data(), u.data());
      for (std::size_t r = 0; r < n; ++r) {
        const Value part = Value(kWeights[i]) * k[r];
        sum[r] = i == 0 ? part : sum[r] + part;
      }
    }
    for (std::size_t r = 0; r < n; ++r) x[r] = x[r] + h * sum[r];
  }

 private:
  template <class Value>
  Value value_of(const Expression& expression, const Value* x, const Value* u) const {
    return expression.evaluate<Value>([&](int j) {
      if (j < nx()) return x[j];
      return j < first_parameter() ? u[j - nx()] : Value(parameter(j - first_parameter()));
    });
  }

  int nu_ = 0;
  std::vector<Expression> derivative_, output_;
  std::vector<double> parameters_;
};

}  // namespace nlo::codegen
