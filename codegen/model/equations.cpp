// SPDX-License-Identifier: MIT
#include "codegen/model/equations.h"

#include <algorithm>

#include "codegen/base/fail.h"
#include "codegen/model/expression_derivative.h"
#include "codegen/model/field_checks.h"

namespace nlo::codegen {

Interval kept_within(Interval x, double low, double high) {
  return {std::clamp(x.low, low, high), std::clamp(x.high, low, high)};
}

Equations::Equations(const EquationTexts& texts, const std::vector<Channel>& states, const std::vector<Channel>& inputs)
    : nx_(static_cast<int>(states.size())),
      ny_(static_cast<int>(texts.outputs.size())),
      nu_(static_cast<int>(inputs.size())) {
  if (states.size() > kMostStates || inputs.size() > kMostInputs)
    fail("equations have {} states and {} inputs; at most {} and {} are allowed", states.size(), inputs.size(),
         kMostStates, kMostInputs);
  if (texts.outputs.size() > kMostOutputs)
    fail("equations have {} outputs; at most {} are allowed", texts.outputs.size(), kMostOutputs);
  if (texts.parameters.size() > kMostParameters)
    fail("equations have {} parameters; at most {} are allowed", texts.parameters.size(), kMostParameters);
  if (texts.derivative.size() != states.size())
    fail("equations.derivative has {} expressions, but there are {} states; give one for each", texts.derivative.size(),
         states.size());
  std::vector<std::string> names;
  for (const Channel& state : states) names.push_back(state.name);
  names.resize(static_cast<std::size_t>(carried()));  // no text names an element of the covariance
  for (const Channel& input : inputs) names.push_back(input.name);
  for (const auto& [name, value] : texts.parameters) {
    names.push_back(name);
    parameters_.push_back(value);
  }
  const auto add = [&](std::vector<Expression>& to, const std::vector<std::string>& from, const char* what) {
    for (std::size_t i = 0; i < from.size(); ++i) try {
        to.emplace_back(from[i], names, Expression::Language::kFunctions);
      } catch (const Error& error) {
        fail(
            "equations.{}[{}]: {}; equations of an observer are sums, products, quotients, whole powers, functions of "
            "one argument, min and max",
            what, i, error.what());
      }
  };
  std::vector<Expression> derivative, output;
  add(derivative, texts.derivative, "derivative");
  append_covariance(derivative);
  derivative_ = SharedExpressions(derivative, static_cast<int>(names.size()));
  add(output, texts.outputs, "outputs");
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i)
      output.push_back(expression_of(nlo::codegen::derivative(output[static_cast<std::size_t>(j)], i)));
  output_ = SharedExpressions(output, static_cast<int>(names.size()));
}

void Equations::append_covariance(std::vector<Expression>& derivative) const {
  const auto slope = [&](int i, int k) { return nlo::codegen::derivative(derivative[static_cast<std::size_t>(i)], k); };
  // Row i of F P, times column j.
  const auto carried_by = [&](int i, int j) {
    ExpressionNodes all;
    for (int k = 0; k < nx_; ++k) all = sum(std::move(all), product(slope(i, k), reading_nodes(place(k, j))));
    return all;
  };
  std::vector<Expression> rows;
  for (int i = 0; i < nx_; ++i)
    for (int j = i; j < nx_; ++j)
      rows.push_back(expression_of(i == j ? product(number_nodes(2.0), carried_by(i, i))
                                          : sum(carried_by(i, j), carried_by(j, i))));
  derivative.insert(derivative.end(), rows.begin(), rows.end());
}

bool Equations::outputs_read_inputs() const {
  const auto reads_input = [this](const Expression& expression) {
    return std::ranges::any_of(expression.nodes(), [this](const Expression::Node& node) {
      return node.kind == Expression::Kind::kReading && node.reading >= first_input() &&
             node.reading < first_parameter();
    });
  };
  return std::ranges::any_of(output_.parts, reads_input) || std::ranges::any_of(output_.rows, reads_input);
}

int Equations::count(int (Expression::*of)() const) const {
  int total = 0;
  const auto add = [&](const SharedExpressions& expressions, int times) {
    for (const auto* some : {&expressions.parts, &expressions.rows})
      for (const Expression& one : *some) total += times * (one.*of)();
  };
  add(derivative_, 4);
  add(output_, 1);
  return total;
}

void check_bounded(const Equations& equations, std::vector<Interval> x, const std::vector<Interval>& u,
                   double sample_period_s) {
  constexpr double kLongestPiece = 1.5;  // sample periods
  const auto check = [](Interval of, const char* what, std::size_t i) {
    if (!of.bounded())
      fail(
          "equations.{}[{}] has no bound for x between state_min and state_max: it may divide by 0, or evaluate a "
          "function outside of its domain; write each divisor so that sums and products of the ranges of its terms do "
          "not reach "
          "0: a - b*c^2, not (a + b + c)*b - (b + c)^2",
          what, i);
    if (!(of.low >= -kLargestNumber && of.high <= kLargestNumber))
      fail("equations.{}[{}] may reach {} to {} for x between state_min and state_max; float32 requires it within +-{}",
           what, i, of.low, of.high, kLargestNumber);
  };
  // The outputs are followed by their slopes, and f by the derivative of the covariance.
  const auto check_all = [&](const std::vector<Interval>& all, const char* first, int count, const char* others) {
    const auto n = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < all.size(); ++i) i < n ? check(all[i], first, i) : check(all[i], others, i - n);
  };
  std::vector<Interval> y(static_cast<std::size_t>(equations.ny() * (1 + equations.nx())));
  equations.output(x.data(), u.data(), y.data());
  check_all(y, "outputs", equations.ny(), "slopes");
  std::vector<Interval> slope(x.size());
  equations.derivative(x.data(), u.data(), slope.data());
  check_all(slope, "derivative", equations.nx(), "covariance");
  equations.step(x.data(), Interval(0.0, kLongestPiece * sample_period_s),
                 [&](double, Interval* to) { std::ranges::copy(u, to); });
  for (Interval& next : x)
    if (!next.bounded()) next = Interval(0.0);
  check_all(x, "derivative", equations.nx(), "covariance");
}

}  // namespace nlo::codegen
