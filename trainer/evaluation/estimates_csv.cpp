// SPDX-License-Identifier: MIT
#include "trainer/evaluation/estimates_csv.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "trainer/base/number_text.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {

std::string estimates_csv(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps) {
  std::string text = "time,step_s";
  for (const Channel& output : model.outputs) text += "," + output.name;
  for (const Channel& input : model.inputs) text += "," + input.name;
  for (const Channel& state : model.states) text += "," + state.name + "_estimate";
  text += ",in_domain";
  for (const Channel& state : model.states) text += "," + state.name + "_truth";
  text += "\n";
  const auto append = [&text](double value) { text += fmt::format(",{:.9g}", value); };  // tells every float apart
  const auto as_shown = [](double value, const Channel& channel) {
    return channel.wrap > 0.0 ? wrap_difference(value, channel.wrap) : value;
  };
  const Trajectory& truth = run.truth;
  for (Eigen::Index k = 0; k < truth.samples(); ++k) {
    text += shortest_text(truth.time_s[k]);
    append(uniform_steps || k == 0 ? 0.0 : truth.time_s[k] - truth.time_s[k - 1]);
    for (Eigen::Index j = 0; j < run.measured.rows(); ++j)
      append(as_shown(run.measured(j, k), model.outputs[static_cast<std::size_t>(j)]));
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(model.inputs.size()); ++i)
      append(truth.inputs.size() > 0 ? truth.inputs(i, k) : 0.0);
    for (Eigen::Index i = 0; i < run.estimate.rows(); ++i) append(run.estimate(i, k));
    append(run.outside.size() > 0 && run.outside[k] > 0.0 ? 0.0 : 1.0);
    for (Eigen::Index i = 0; i < truth.states.rows(); ++i)
      append(truth.weight[k] > 0.0 ? as_shown(truth.states(i, k), model.states[static_cast<std::size_t>(i)])
                                   : std::numeric_limits<double>::quiet_NaN());
    text += "\n";
  }
  return text;
}

}  // namespace nlo::trainer
