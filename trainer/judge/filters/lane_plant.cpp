// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/lane_plant.h"

#include <algorithm>
#include <cmath>

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
  known.h = [plant](const MatrixXd& x, const MatrixXd&) { return plant->output(x); };
  const auto wraps_of = [](const std::vector<codegen::Channel>& channels) {
    Eigen::VectorXd wraps(static_cast<Index>(channels.size()));
    std::transform(channels.begin(), channels.end(), wraps.begin(), [](const auto& channel) { return channel.wrap; });
    return wraps;
  };
  known.output_wraps = wraps_of(plant->outputs());
  known.state_wraps = wraps_of(plant->states());
  return known;
}

MatrixXd LaneRuns::inputs_at(Index k) const {
  return inputs.empty() ? MatrixXd() : inputs[static_cast<std::size_t>(k)];
}

LaneRuns one_run(const MatrixXd& outputs, const MatrixXd& inputs, const Eigen::VectorXd& time_s, bool held_inputs) {
  LaneRuns run;
  run.held_inputs = held_inputs;
  run.time_s = time_s;
  if (time_s.size() > 1) run.sample_period_s = time_s[1] - time_s[0];
  for (Index k = 0; k < outputs.cols(); ++k) run.outputs.emplace_back(outputs.col(k));
  for (Index k = 0; k < inputs.cols(); ++k) run.inputs.emplace_back(inputs.col(k));
  return run;
}

LaneRuns repeated(const LaneRuns& runs, Index times) {
  LaneRuns result = runs;
  for (MatrixXd& y : result.outputs) y = y.replicate(1, times).eval();
  for (MatrixXd& u : result.inputs) u = u.replicate(1, times).eval();
  return result;
}

LaneInputs inputs_before(const LaneRuns& runs, Index k) {
  return {runs.inputs_at(runs.held_inputs || k == 0 ? k : k - 1), runs.inputs_at(k)};
}

double rk4_steps(double h, double longest_step_s) {
  // Less than 1e-9 of a step is the rounding of time stamps.
  return std::max(1.0, std::ceil(std::abs(h) / longest_step_s - 1e-9));
}

MatrixXd advance(const LanePlant& plant, const MatrixXd& x, double h, const LaneInputs& u) {
  const Index blocks = u.to.size() == 0 ? 0 : x.cols() / u.to.cols();
  const double steps = rk4_steps(h, plant.longest_step_s);
  MatrixXd next = x;
  for (double i = 0.0; i < steps; i += 1.0)
    next = codegen::rk4_step(next, h / steps, [&](double c, const MatrixXd& at) {
      if (blocks == 0) return plant.f(at, MatrixXd());
      const double share = (i + c) / steps;
      return plant.f(at, ((1.0 - share) * u.from + share * u.to).replicate(1, blocks).eval());
    });
  return next;
}

MatrixXd output_at(const LanePlant& plant, const MatrixXd& x, const MatrixXd& u) {
  return plant.h(x, u.size() == 0 ? u : u.replicate(1, x.cols() / u.cols()).eval());
}

FilteredRun filtered(LaneFilter& filter, const LaneRuns& run) {
  FilteredRun all;
  for (Index k = 0; k < run.samples(); ++k) {
    const MatrixXd x = filter.step(run, k), deviations = filter.deviations();
    if (k == 0) all = {MatrixXd(x.rows(), run.samples()), MatrixXd(deviations.rows(), run.samples())};
    all.x_hat.col(k) = x;
    if (deviations.size() > 0) all.deviations.col(k) = deviations;
  }
  return all;
}

}  // namespace nlo::trainer
