// SPDX-License-Identifier: MIT
#include "trainer/identify/segment_simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/reference/rk4.h"
#include "trainer/data/angle.h"
#include "trainer/identify/shooting.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd simulate_step(ParametricPlant& plant, VectorXd x, double h, const VectorXd& u0, const VectorXd& u1,
                       double longest_step_s) {
  const double steps = longest_step_s > 0.0 ? std::max(1.0, std::ceil(h / longest_step_s - 1e-9)) : 1.0;
  for (double i = 0.0; i < steps; i += 1.0)
    x = codegen::rk4_step(x, h / steps, [&](double c, const VectorXd& at) {
      const double share = (i + c) / steps;
      return plant.derivative(at, (1.0 - share) * u0 + share * u1);
    });
  return x;
}

SegmentSimulation::SegmentSimulation(const Identification& identification, const std::vector<FittedChannel>& channels,
                                     const std::vector<Index>& input_rows)
    : config_(identification.identify), channels_(channels), input_rows_(input_rows), plant_(identification.plant) {}

VectorXd SegmentSimulation::inputs_at(const Trajectory& run, Index sample) const {
  VectorXd u(static_cast<Index>(input_rows_.size()));
  for (std::size_t i = 0; i < input_rows_.size(); ++i) u[static_cast<Index>(i)] = run.inputs(input_rows_[i], sample);
  return u;
}

VectorXd SegmentSimulation::residuals(const Trajectory& run, Index first, Index samples, const VectorXd& p,
                                      const VectorXd& x0) {
  plant_.set_parameters(p);
  const auto count = static_cast<Index>(channels_.size());
  VectorXd r(samples * count), x = x0, u = inputs_at(run, first);
  for (Index k = 0; k < samples; ++k) {
    const Index sample = first + k;
    if (k > 0) {
      const VectorXd next = inputs_at(run, sample);
      const double h = run.time_s[sample] - run.time_s[sample - 1];
      x = simulate_step(plant_, std::move(x), h, config_.input_hold == Hold::kZeroOrder ? next : u, next,
                        config_.longest_step_s);
      u = next;
    }
    const VectorXd y = plant_.output(x, u);
    for (Index c = 0; c < count; ++c) {
      const FittedChannel& channel = channels_[static_cast<std::size_t>(c)];
      double& residual = r[k * count + c];
      residual = 0.0;
      if (channel.state && run.weight[sample] <= 0.0) continue;
      if (!channel.state && run.missing.size() != 0 && run.missing(channel.log_row, sample)) continue;
      const double measured = (channel.state ? run.states : run.outputs)(channel.log_row, sample);
      double error = measured - (channel.state ? x : y)[channel.plant_row];
      if (channel.wrap > 0.0) error = wrap_difference(error, channel.wrap);
      residual = error / channel.deviation;
    }
  }
  return r;
}

}  // namespace nlo::trainer
