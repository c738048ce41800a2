// SPDX-License-Identifier: MIT
#include "codegen/model/computed_outputs.h"

#include <algorithm>

#include "codegen/base/fail.h"

namespace nlo::codegen {

int measured_outputs(const std::vector<Channel>& outputs) {
  return static_cast<int>(
      std::count_if(outputs.begin(), outputs.end(), [](const Channel& output) { return output.expression.empty(); }));
}

ComputedOutputs::ComputedOutputs(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs)
    : first_(measured_outputs(outputs)), outputs_(static_cast<int>(outputs.size())) {
  // Names in the order of the readings; empty for a reading that an expression may not use.
  std::vector<std::string> names;
  for (const Channel& output : outputs)
    names.push_back(output.wrap > 0.0 || !output.expression.empty() ? "" : output.name);
  for (const Channel& input : inputs) names.push_back(input.name);
  for (std::size_t j = 0; j < outputs.size(); ++j) {
    const Channel& output = outputs[j];
    if (output.expression.empty()) {
      if (static_cast<int>(j) >= first_)
        fail("output \"{}\" is measured but follows computed outputs; put outputs with an expression last",
             output.name);
      continue;
    }
    if (output.wrap != 0.0)
      fail("output \"{}\" has an expression and a wrap, but a computed output cannot be an angle: leave the wrap out",
           output.name);
    try {
      expressions_.emplace_back(output.expression, names);
    } catch (const Error& error) {
      fail("output \"{}\": {}", output.name, error.what());
    }
  }
}

void ComputedOutputs::fill(Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs) const {
  for (std::size_t i = 0; i < expressions_.size(); ++i)
    for (Eigen::Index k = 0; k < outputs.cols(); ++k)
      outputs(first_ + static_cast<Eigen::Index>(i), k) = expressions_[i].evaluate<double>(
          [&](int j) { return j < outputs_ ? outputs(j, k) : inputs(j - outputs_, k); });
}

}  // namespace nlo::codegen
