// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/closed_loop.h"

#include <fmt/format.h>

#include <cmath>

#include "codegen/base/error.h"
#include "trainer/plants/state_feedback.h"

namespace nlo::trainer {

ClosedLoopCost closed_loop_cost(const Dataset& of_true_state, const Dataset& of_estimator) {
  const auto& ideal = of_true_state.trajectories;
  const auto& flown = of_estimator.trajectories;
  if (ideal.size() != flown.size() || ideal.empty())
    throw codegen::Error("two loops are compared run by run, so they must have the same number of runs, at least one");
  Eigen::VectorXd reach = Eigen::VectorXd::Zero(ideal.front().states.rows()), squares = reach;
  Eigen::Index samples = 0;
  for (const Trajectory& run : ideal) reach = reach.cwiseMax(run.states.cwiseAbs().rowwise().maxCoeff());
  ClosedLoopCost cost;
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    squares += (flown[i].states - ideal[i].states).rowwise().squaredNorm();
    samples += ideal[i].samples();
    const Eigen::VectorXd most = flown[i].states.cwiseAbs().rowwise().maxCoeff();
    cost.left += (most.array() > kLeft * reach.array()).any() ? 1 : 0;
  }
  cost.runs = static_cast<int>(ideal.size());
  cost.deviation = (squares / static_cast<double>(samples)).cwiseSqrt();
  return cost;
}

std::optional<double> mean_cost(const Experiment& experiment, const Plant& plant, const Dataset& runs) {
  if (!experiment.feedback || experiment.feedback->cost.empty()) return std::nullopt;
  LoopCost cost(*experiment.feedback, plant, experiment.plant->parameters);
  double sum = 0.0;
  Eigen::Index samples = 0;
  for (const Trajectory& run : runs.trajectories) {
    for (Eigen::Index k = 0; k < run.samples(); ++k) sum += cost(run.states.col(k), run.inputs.col(k));
    samples += run.samples();
  }
  return sum / static_cast<double>(samples);
}

std::string to_text(const ClosedLoopCost& cost, const std::vector<Channel>& channels) {
  std::string states;
  for (std::size_t i = 0; i < channels.size(); ++i)
    states +=
        fmt::format("{}{} {:.3g}", i == 0 ? "" : ", ", channels[i].name, cost.deviation(static_cast<Eigen::Index>(i)));
  const std::string price = cost.cost && cost.of_true_state ? fmt::format("cost {:.4g}, with the true state {:.4g}; ",
                                                                          *cost.cost, *cost.of_true_state)
                                                            : "";
  return fmt::format(
      "{}RMS distance of the states from the loop that feeds back the true state: {}; {} of {} runs exceed {:g} times "
      "the range of that loop",
      price, states, cost.left, cost.runs, kLeft);
}

}  // namespace nlo::trainer
