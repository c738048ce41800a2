// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/filter_bank.h"

#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;

std::vector<FilterTuning> times(const std::vector<FilterTuning>& tunings, Index members) {
  std::vector<FilterTuning> all;
  for (Index b = 0; b < members; ++b) all.insert(all.end(), tunings.begin(), tunings.end());
  return all;
}

}  // namespace

FilterBank::FilterBank(const LanePlant& plant, PointSet points, const FilterKnowledge& knowledge,
                       const MatrixXd& starts, const std::vector<FilterTuning>& tunings, Index lanes)
    : members_(starts.cols()),
      lanes_(lanes),
      state_wraps_(plant.state_wraps.size() > 0 ? plant.state_wraps : Eigen::VectorXd::Zero(plant.nx)),
      bank_(plant, points, knowledge, times(tunings, members_), members_ * lanes),
      log_weight_(ArrayXXd::Zero(members_, lanes)),
      weights_(ArrayXXd::Constant(members_, lanes, 1.0 / static_cast<double>(members_))) {
  MatrixXd all(starts.rows(), members_ * lanes);
  for (Index b = 0; b < members_; ++b) all.middleCols(b * lanes, lanes) = starts.col(b).replicate(1, lanes);
  bank_.start_at(all);
}

MatrixXd FilterBank::step(const LaneRuns& runs, Index k) {
  constexpr double kLeast = -30.0;  // smallest log weight, so that a filter that was wrong for long can still recover
  samples_.sample_period_s = runs.sample_period_s;
  samples_.held_inputs = runs.held_inputs;
  samples_.time_s = runs.time_s;
  samples_.outputs.push_back(runs.outputs[static_cast<std::size_t>(k)].replicate(1, members_));
  if (!runs.inputs.empty()) samples_.inputs.push_back(runs.inputs[static_cast<std::size_t>(k)].replicate(1, members_));
  const MatrixXd x = bank_.step(samples_, k);
  for (Index b = 0; b < members_; ++b)
    log_weight_.row(b) += bank_.log_likelihood().segment(b * lanes_, lanes_).transpose();
  MatrixXd estimate(x.rows(), lanes_);
  for (Index lane = 0; lane < lanes_; ++lane) {
    auto log_w = log_weight_.col(lane);
    Index likeliest = 0;
    log_w = (log_w - log_w.maxCoeff(&likeliest)).max(kLeast).eval();
    weights_.col(lane) = log_w.exp() / log_w.exp().sum();
    const Eigen::VectorXd centre = x.col(likeliest * lanes_ + lane);
    estimate.col(lane) = centre;
    for (Index b = 0; b < members_; ++b) {
      Eigen::VectorXd away = x.col(b * lanes_ + lane) - centre;
      for (Index i = 0; i < away.size(); ++i)
        if (state_wraps_[i] > 0.0) away[i] = wrap_difference(away[i], state_wraps_[i]);
      estimate.col(lane) += weights_(b, lane) * away;
    }
  }
  return estimate;
}

}  // namespace nlo::trainer
