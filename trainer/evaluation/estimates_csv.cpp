// SPDX-License-Identifier: MIT
#include "trainer/evaluation/estimates_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/base/number_text.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {

std::string estimates_csv(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps,
                          const std::vector<std::string>& unscored) {
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
  const Eigen::MatrixXd& estimate = run.all_estimates.size() > 0 ? run.all_estimates : run.estimate;
  for (Eigen::Index k = 0; k < truth.samples(); ++k) {
    text += shortest_text(truth.time_s[k]);
    append(uniform_steps || k == 0 ? 0.0 : truth.time_s[k] - truth.time_s[k - 1]);
    for (Eigen::Index j = 0; j < run.measured.rows(); ++j)
      append(as_shown(run.measured(j, k), model.outputs[static_cast<std::size_t>(j)]));
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(model.inputs.size()); ++i)
      append(truth.inputs.size() > 0 ? truth.inputs(i, k) : 0.0);
    for (Eigen::Index i = 0; i < estimate.rows(); ++i) append(estimate(i, k));
    append(run.outside.size() > 0 && run.outside[k] > 0.0 ? 0.0 : 1.0);
    Eigen::Index row = 0;
    for (const Channel& state : model.states) {
      const bool is_known = std::find(unscored.begin(), unscored.end(), state.name) == unscored.end();
      append(is_known && truth.weight[k] > 0.0 ? as_shown(truth.states(row, k), state)
                                               : std::numeric_limits<double>::quiet_NaN());
      row += is_known ? 1 : 0;
    }
    text += "\n";
  }
  return text;
}

}  // namespace nlo::trainer
