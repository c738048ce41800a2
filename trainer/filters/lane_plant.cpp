// SPDX-License-Identifier: MIT
#include "trainer/filters/lane_plant.h"

#include "codegen/reference/rk4.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;

LanePlant lane_plant(const std::shared_ptr<const Plant>& plant) {
  LanePlant known;
  known.nx = plant->nx();
  known.ny = plant->ny();
  known.f = [plant](const MatrixXd& x, const MatrixXd& u) {
    return u.size() == 0 ? plant->derivative(x) : plant->driven_derivative(x, u);
  };
  known.h = [plant](const MatrixXd& x) { return plant->output(x); };
  known.output_wraps.resize(known.ny);
  for (Index j = 0; j < known.ny; ++j) known.output_wraps[j] = plant->outputs()[static_cast<std::size_t>(j)].wrap;
  return known;
}

LaneRuns repeated(const LaneRuns& runs, Index times) {
  LaneRuns result = runs;
  for (MatrixXd& y : result.outputs) y = y.replicate(1, times).eval();
  for (MatrixXd& u : result.inputs) u = u.replicate(1, times).eval();
  return result;
}

LaneRuns lane_of(const LaneRuns& runs, Index lane) {
  LaneRuns result = runs;
  for (MatrixXd& y : result.outputs) y = y.col(lane).eval();
  for (MatrixXd& u : result.inputs) u = u.col(lane).eval();
  return result;
}

LaneInputs inputs_before(const LaneRuns& runs, Index k) {
  if (runs.inputs.empty()) return {};
  const auto at = static_cast<std::size_t>(k);
  return {runs.inputs[runs.held_inputs || k == 0 ? at : at - 1], runs.inputs[at]};
}

MatrixXd advance(const LanePlant& plant, const MatrixXd& x, double h, const LaneInputs& u) {
  if (u.to.size() == 0)
    return codegen::rk4_step(x, h, [&](double, const MatrixXd& at) { return plant.f(at, MatrixXd()); });
  const Index blocks = x.cols() / u.to.cols();
  return codegen::rk4_step(x, h, [&](double c, const MatrixXd& at) {
    return plant.f(at, ((1.0 - c) * u.from + c * u.to).replicate(1, blocks).eval());
  });
}

}  // namespace nlo::trainer
