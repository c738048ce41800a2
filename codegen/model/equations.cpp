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
        to.emplace_back(from[i], names);
      } catch (const Error& error) {
        fail("equations.{}[{}]: {}; equations of an observer are sums, products and whole powers", what, i,
             error.what());
      }
  };
  add(derivative_, texts.derivative, "derivative");
  for (std::size_t j = 0; j < inputs.size(); ++j) names[states.size() + j] = "";  // an output is of the state alone
  add(output_, texts.outputs, "outputs");
}

}  // namespace nlo::codegen
