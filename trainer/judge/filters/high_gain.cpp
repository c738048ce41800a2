// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/high_gain.h"

#include <cmath>

#include "codegen/base/linear_algebra.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string no_high_gain(Index nx, Index ny, Index nu) {
  if (ny != 1) return "a high-gain observer needs exactly one output";
  if (nx > 3) return "this high-gain observer supports at most three states";
  if (nu > 0) return "this high-gain observer supports no inputs, because their derivatives would be needed";
  return "";
}

HighGainObserver::HighGainObserver(const LanePlant& plant, const FilterKnowledge& knowledge,
                                   const std::vector<FilterTuning>& tunings, Index lanes, double sample_period_s)
    : plant_(plant),
      x_(knowledge.initial_state.replicate(1, lanes)),
      initial_state_(x_),
      gains_(plant.nx, lanes),
      limits_(knowledge.limits()),
      step_(1e-4 * knowledge.initial_covariance.diagonal().cwiseSqrt().cwiseMax(1e-3)) {
  const double h = sample_period_s;
  const Index each = lanes / static_cast<Index>(tunings.size());
  for (Index lane = 0; lane < lanes; ++lane) {
    const double theta = std::sqrt(tunings[static_cast<std::size_t>(lane / each)].process) / (20.0 * h);
    const double beta = std::exp(-theta * h), rest = 1.0 - beta;
    if (plant.nx == 1) gains_(0, lane) = rest;
    if (plant.nx == 2) gains_.col(lane) << 1.0 - beta * beta, rest * rest / h;
    if (plant.nx == 3)
      gains_.col(lane) << 1.0 - beta * beta * beta, 1.5 * rest * rest * (1.0 + beta) / h, rest * rest * rest / (h * h);
  }
}

MatrixXd HighGainObserver::step(const LaneRuns& runs, Index k) {
  const Index nx = plant_.nx, lanes = x_.cols();
  const double h = k > 0 ? runs.step_s(k) : runs.sample_period_s;
  if (k > 0) x_ = advance(plant_, x_, h, {});
  MatrixXd points = x_.replicate(1, 2 * nx + 1);
  for (Index j = 0; j < nx; ++j) {
    points.row(j).segment((1 + 2 * j) * lanes, lanes).array() += step_[j];
    points.row(j).segment((2 + 2 * j) * lanes, lanes).array() -= step_[j];
  }
  MatrixXd derivatives(nx, points.cols());  // y, y', y'' at the points
  derivatives.row(0) = plant_.h(points, {});
  if (nx > 1) {
    const MatrixXd later = plant_.h(advance(plant_, points, h, {}), {});
    const MatrixXd before = plant_.h(advance(plant_, points, -h, {}), {});
    derivatives.row(1) = (later - before) / (2.0 * h);
    if (nx > 2) derivatives.row(2) = (later + before - 2.0 * derivatives.row(0)) / (h * h);
  }
  const MatrixXd& y = runs.outputs[static_cast<std::size_t>(k)];
  for (Index lane = 0; lane < lanes; ++lane) {
    double innovation = y(0, lane) - derivatives(0, lane);
    if (std::isnan(innovation)) continue;
    if (plant_.output_wraps[0] > 0.0) innovation = wrap_difference(innovation, plant_.output_wraps[0]);
    MatrixXd observability(nx, nx);
    for (Index j = 0; j < nx; ++j)
      observability.col(j) =
          (derivatives.col((1 + 2 * j) * lanes + lane) - derivatives.col((2 + 2 * j) * lanes + lane)) /
          (2.0 * step_[j]);
    x_.col(lane) += codegen::solve(observability, gains_.col(lane) * innovation);
    if ((x_.col(lane).array().abs() <= limits_).all()) continue;
    ++restarts_;
    x_.col(lane) = initial_state_.col(lane);
  }
  return x_;
}

}  // namespace nlo::trainer
