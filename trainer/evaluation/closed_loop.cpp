// SPDX-License-Identifier: MIT
#include "trainer/evaluation/closed_loop.h"

#include <fmt/format.h>

#include "codegen/base/error.h"

namespace nlo::trainer {

ClosedLoopCost closed_loop_cost(const Dataset& of_true_state, const Dataset& of_observer) {
  const auto& ideal = of_true_state.trajectories;
  const auto& flown = of_observer.trajectories;
  if (ideal.size() != flown.size() || ideal.empty())
    throw codegen::Error("two loops are compared run by run, and one set has more runs than the other, or none");
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

std::string to_text(const ClosedLoopCost& cost, const Dataset& dataset) {
  std::string states;
  for (std::size_t i = 0; i < dataset.states.size(); ++i)
    states += fmt::format("{}{} {:.3g}", i == 0 ? "" : ", ", dataset.states[i].name,
                          cost.deviation(static_cast<Eigen::Index>(i)));
  return fmt::format(
      "in closed loop, states are off those of the same feedback of the true state by (RMS): {}; {} of {} runs go "
      "beyond {:g} times its range",
      states, cost.left, cost.runs, kLeft);
}

}  // namespace nlo::trainer
