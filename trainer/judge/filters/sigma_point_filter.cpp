// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/sigma_point_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kDifferenceSpread = 1e-4;  // step in deviations: relative truncation 1e-8 and rounding 1e-12
constexpr double kTiny = 1e-300;            // keeps quotients finite in lanes without any uncertainty

double kappa(Index nx) {
  return std::max(0.0, 3.0 - static_cast<double>(nx));
}

/// Returns an array over the lanes: each lane has the value of its tuning.
template <class Value>
ArrayXd by_lane(const std::vector<FilterTuning>& tunings, Index lanes, const Value& value) {
  ArrayXd result(lanes);
  const Index each = lanes / static_cast<Index>(tunings.size());
  for (std::size_t t = 0; t < tunings.size(); ++t)
    result.segment(static_cast<Index>(t) * each, each).setConstant(value(tunings[t]));
  return result;
}

}  // namespace

SigmaPointFilter::SigmaPointFilter(LanePlant plant, PointSet points, const FilterKnowledge& knowledge,
                                   const std::vector<FilterTuning>& tunings, Index lanes)
    : plant_(std::move(plant)),
      kind_(points),
      nx_(knowledge.initial_state.size()),
      lanes_(lanes),
      x_(knowledge.initial_state.replicate(1, lanes)),
      initial_state_(x_),
      limits_(knowledge.limits()),
      process_deviation_(knowledge.process_deviation),
      process_noise_(ArrayXd::Zero(nx_)),
      root_(nx_, nx_, lanes),
      initial_root_(root_) {
  const auto n = static_cast<double>(nx_);
  spread_ = kind_ == PointSet::kExtended ? kDifferenceSpread : std::sqrt(n + kappa(nx_));
  centre_weight_ = kappa(nx_) / (n + kappa(nx_));
  weight_ = 0.5 / (n + kappa(nx_));
  const auto of_state = [](double all, const std::vector<double>& each, Index i) {
    return std::sqrt(each.empty() ? all : all * each[static_cast<std::size_t>(i)]);
  };
  for (Index i = 0; i < nx_; ++i)
    process_factor_.push_back(
        by_lane(tunings, lanes, [&](const FilterTuning& t) { return of_state(t.process, t.process_of, i); }));
  const ArrayXd output = by_lane(tunings, lanes, [](const FilterTuning& t) { return t.output; });
  if (knowledge.process_noise.size() > 0) process_noise_ = knowledge.process_noise;
  const MatrixXd root = codegen::square_root(knowledge.initial_covariance);
  LaneMatrix w(nx_, nx_, lanes);
  for (Index i = 0; i < nx_; ++i) {
    const ArrayXd initial =
        by_lane(tunings, lanes, [&](const FilterTuning& t) { return of_state(t.initial, t.initial_of, i); });
    for (Index j = 0; j < nx_; ++j) w(i, j) = initial * root(i, j);
  }
  triangularise(w);  // gives a triangular root even if P0 is only semidefinite
  initial_root_ = root_;
  for (const double deviation : knowledge.output_deviation)
    output_variance_.emplace_back(output * deviation * deviation);
  squared_gate_ = by_lane(tunings, lanes, [](const FilterTuning& t) { return t.gate * t.gate; });
  rejected_.assign(output_variance_.size(), Eigen::ArrayXi::Zero(lanes));
}

/// Returns blocks of L columns: x, x + d S_1, x - d S_1, x + d S_2, ...
MatrixXd SigmaPointFilter::points() const {
  MatrixXd all = x_.replicate(1, 2 * nx_ + 1);
  for (Index j = 0; j < nx_; ++j)
    for (Index i = 0; i < nx_; ++i) {
      const ArrayXd off = spread_ * root_(i, j);
      all.row(i).segment((1 + 2 * j) * lanes_, lanes_).array() += off.transpose();
      all.row(i).segment((2 + 2 * j) * lanes_, lanes_).array() -= off.transpose();
    }
  return all;
}

/// Computes root_ = L of W = L [orthonormal rows], by modified Gram and Schmidt on the rows of W.
void SigmaPointFilter::triangularise(LaneMatrix& w) {
  for (Index i = 0; i < nx_; ++i) {
    for (Index j = 0; j < nx_; ++j) root_(i, j).setZero();
  }
  for (Index i = 0; i < nx_; ++i) {
    ArrayXd squares = ArrayXd::Zero(lanes_);
    for (Index c = 0; c < w.cols(); ++c) squares += w(i, c).square();
    root_(i, i) = squares.sqrt();
    const ArrayXd inverse = 1.0 / (root_(i, i) + kTiny);
    for (Index c = 0; c < w.cols(); ++c) w(i, c) *= inverse;
    for (Index below = i + 1; below < nx_; ++below) {
      ArrayXd product = ArrayXd::Zero(lanes_);
      for (Index c = 0; c < w.cols(); ++c) product += w(below, c) * w(i, c);
      root_(below, i) = product;
      for (Index c = 0; c < w.cols(); ++c) w(below, c) -= product * w(i, c);
    }
  }
}

void SigmaPointFilter::predict(const LaneRuns& runs, Index k) {
  if (k == 0) return;
  const double h = runs.step_s(k);
  const MatrixXd next = advance(plant_, points(), h, inputs_before(runs, k));
  const auto block = [&](Index i, Index b) { return next.row(i).segment(b * lanes_, lanes_).transpose().array(); };
  const bool extended = kind_ == PointSet::kExtended;
  LaneMatrix w(nx_, (extended ? nx_ : 2 * nx_ + 1) + nx_, lanes_);
  for (Index i = 0; i < nx_; ++i) {
    Index column = 0;
    if (extended) {
      x_.row(i) = next.row(i).head(lanes_);
      for (Index j = 0; j < nx_; ++j) w(i, column++) = (block(i, 1 + 2 * j) - block(i, 2 + 2 * j)) * (0.5 / spread_);
    } else {
      ArrayXd mean = centre_weight_ * block(i, 0);
      for (Index b = 1; b <= 2 * nx_; ++b) mean += weight_ * block(i, b);
      w(i, column++) = std::sqrt(centre_weight_) * (block(i, 0) - mean);
      for (Index b = 1; b <= 2 * nx_; ++b) w(i, column++) = std::sqrt(weight_) * (block(i, b) - mean);
      x_.row(i) = mean.transpose();
    }
    w(i, column + i) = process_factor_[static_cast<std::size_t>(i)] *
                       std::sqrt(std::pow(process_deviation_[i], 2) + h * std::pow(process_noise_[i], 2));
  }
  triangularise(w);
}

void SigmaPointFilter::correct_one(Index output, const MatrixXd& y, const MatrixXd& u) {
  const auto at = static_cast<std::size_t>(output);
  const MatrixXd seen = output_at(plant_, points(), u);
  const double wrap = plant_.output_wraps[output];
  const ArrayXd centre = seen.row(output).head(lanes_).transpose().array();
  const auto short_way = [wrap](ArrayXd d) -> ArrayXd {
    if (wrap > 0.0) d = d.unaryExpr([wrap](double v) { return wrap_difference(v, wrap); });
    return d;
  };
  const auto off_centre = [&](Index b) {
    return short_way(seen.row(output).segment(b * lanes_, lanes_).transpose().array() - centre);
  };
  std::vector<ArrayXd> phi;
  ArrayXd mean = ArrayXd::Zero(lanes_), linear = ArrayXd::Zero(lanes_), variance = output_variance_[at];
  const bool extended = kind_ == PointSet::kExtended;
  ArrayXd squares = ArrayXd::Zero(lanes_);
  for (Index j = 0; j < nx_; ++j) {
    const ArrayXd plus = off_centre(1 + 2 * j), minus = off_centre(2 + 2 * j);
    phi.emplace_back((plus - minus) * (extended ? 0.5 / spread_ : weight_ * spread_));
    linear += phi.back().square();
    if (extended) continue;
    mean += weight_ * (plus + minus);
    squares += weight_ * (plus.square() + minus.square());
  }
  variance += extended ? linear : (squares - mean.square()).max(linear);
  const ArrayXd innovation = short_way(y.row(output).transpose().array() - centre - mean);
  const auto arrived = innovation == innovation;
  const auto inside = innovation.square() <= squared_gate_ * variance;
  const Eigen::Array<bool, Eigen::Dynamic, 1> used = arrived && inside;
  Eigen::ArrayXi& rejected = rejected_[at];
  rejected = used.select(0, arrived.select(rejected + 1, rejected));

  log_likelihood_ -= arrived.select(
      (0.5 * (variance.max(kTiny).log() + (innovation.square() / variance).min(squared_gate_))).eval(), 0.0);

  const ArrayXd gain = used.select((innovation / variance).eval(), 0.0);
  const ArrayXd shrink =
      used.select((1.0 / (variance + (variance * (variance - linear).max(0.0)).sqrt() + kTiny)).eval(), 0.0);
  for (Index i = 0; i < nx_; ++i) {
    ArrayXd spread = ArrayXd::Zero(lanes_);
    for (Index j = 0; j < nx_; ++j) spread += root_(i, j) * phi[static_cast<std::size_t>(j)];
    x_.row(i) += (gain * spread).matrix().transpose();
    const ArrayXd step = shrink * spread;
    for (Index j = 0; j < nx_; ++j) root_(i, j) -= step * phi[static_cast<std::size_t>(j)];
  }
  if (!(rejected >= kMostRejected).any()) return;
  for (Index i = 0; i < nx_; ++i)
    for (Index j = 0; j < nx_; ++j) root_(i, j) = (rejected >= kMostRejected).select(initial_root_(i, j), root_(i, j));
  rejected = (rejected >= kMostRejected).select(0, rejected);
}

void SigmaPointFilter::start_at(const MatrixXd& states) {
  x_ = initial_state_ = states;
}

void SigmaPointFilter::restart_lost() {
  for (Index lane = 0; lane < lanes_; ++lane) {
    if ((x_.col(lane).array().abs() <= limits_).all()) continue;
    ++restarts_;
    x_.col(lane) = initial_state_.col(lane);
    for (Index i = 0; i < nx_; ++i)
      for (Index j = 0; j < nx_; ++j) root_(i, j)[lane] = initial_root_(i, j)[lane];
  }
}

void SigmaPointFilter::correct(const LaneRuns& runs, Index k) {
  const MatrixXd u = runs.inputs_at(k);
  log_likelihood_ = ArrayXd::Zero(lanes_);
  for (Index j = 0; j < plant_.ny; ++j) correct_one(j, runs.outputs[static_cast<std::size_t>(k)], u);
  restart_lost();
}

MatrixXd SigmaPointFilter::deviations() const {
  MatrixXd result(nx_, lanes_);
  for (Index i = 0; i < nx_; ++i) {
    ArrayXd squares = ArrayXd::Zero(lanes_);
    for (Index j = 0; j < nx_; ++j) squares += root_(i, j).square();
    result.row(i) = squares.sqrt().matrix().transpose();
  }
  return result;
}

MatrixXd SigmaPointFilter::step(const LaneRuns& runs, Index k) {
  predict(runs, k);
  restart_lost();
  correct(runs, k);
  return x_;
}

}  // namespace nlo::trainer
