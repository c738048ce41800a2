// SPDX-License-Identifier: MIT
#include "codegen/model/equations.h"

#include <algorithm>

#include "codegen/base/fail.h"

namespace nlo::codegen {

Interval kept_within(Interval x, double low, double high) {
  return {std::clamp(x.low, low, high), std::clamp(x.high, low, high)};
}

Equations::Equations(const EquationTexts& texts, const std::vector<Channel>& states, const std::vector<Channel>& inputs)
    : nu_(static_cast<int>(inputs.size())) {
  if (states.size() > kMostStates || inputs.size() > kMostInputs)
    fail("equations have {} states and {} inputs; {} and {} are the most", states.size(), inputs.size(), kMostStates,
         kMostInputs);
  if (texts.outputs.size() > kMostOutputs)
    fail("equations have {} outputs; {} are the most", texts.outputs.size(), kMostOutputs);
  if (texts.derivative.size() != states.size())
    fail("equations.derivative has {} expressions, and there are {} states; give one for each", texts.derivative.size(),
         states.size());
  std::vector<std::string> names;
  for (const Channel& state : states) names.push_back(state.name);
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
            "equations.{}[{}]: {}; equations of an observer are sums, products, quotients, whole powers and functions "
            "of "
            "one argument",
            what, i, error.what());
      }
  };
  std::vector<Expression> derivative, output;
  add(derivative, texts.derivative, "derivative");
  derivative_ = SharedExpressions(derivative, static_cast<int>(names.size()));
  for (std::size_t j = 0; j < inputs.size(); ++j) names[states.size() + j] = "";  // an output is of the state alone
  add(output, texts.outputs, "outputs");
  output_ = SharedExpressions(output, static_cast<int>(names.size()));
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

}  // namespace nlo::codegen
