// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/moving_horizon.h"

#include <algorithm>

#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kSpread = 1e-4;  // one-sided step in deviations; enough for a Gauss-Newton step

/// Solves A x = b for a symmetric positive A of each lane, by Cholesky's method in place; x replaces b.
void solve_lanes(LaneMatrix& a, std::vector<ArrayXd>& b) {
  const auto n = static_cast<Index>(b.size());
  for (Index j = 0; j < n; ++j) {
    for (Index k = 0; k < j; ++k) a(j, j) -= a(j, k).square();
    a(j, j) = a(j, j).max(1e-300).sqrt();
    for (Index i = j + 1; i < n; ++i) {
      for (Index k = 0; k < j; ++k) a(i, j) -= a(i, k) * a(j, k);
      a(i, j) /= a(j, j);
    }
  }
  const auto at = [&](Index i) -> ArrayXd& { return b[static_cast<std::size_t>(i)]; };
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < i; ++k) at(i) -= a(i, k) * at(k);
    at(i) /= a(i, i);
  }
  for (Index i = n - 1; i >= 0; --i) {
    for (Index k = i + 1; k < n; ++k) at(i) -= a(k, i) * at(k);
    at(i) /= a(i, i);
  }
}

}  // namespace

MovingHorizonFilter::MovingHorizonFilter(const LanePlant& plant, const FilterKnowledge& knowledge,
                                         const std::vector<FilterTuning>& tunings, Index lanes, Index window)
    : plant_(plant),
      nx_(knowledge.initial_state.size()),
      lanes_(lanes),
      window_(window),
      arrival_(plant, PointSet::kExtended, knowledge, tunings, lanes),
      x_(knowledge.initial_state.replicate(1, lanes)),
      limits_(knowledge.limits()),
      gate_(lanes) {
  ArrayXd output(lanes);
  const Index each = lanes / static_cast<Index>(tunings.size());
  for (std::size_t t = 0; t < tunings.size(); ++t) {
    const Index first = static_cast<Index>(t) * each;
    output.segment(first, each).setConstant(tunings[t].output);
    gate_.segment(first, each).setConstant(tunings[t].gate);
  }
  for (const double deviation : knowledge.output_deviation)
    output_variance_.emplace_back(output * deviation * deviation);
}

MatrixXd MovingHorizonFilter::step(const LaneRuns& runs, Index k) {
  const auto y_of = [&](Index i) -> const MatrixXd& { return runs.outputs[static_cast<std::size_t>(i)]; };
  if (k - start_ >= window_) {
    arrival_.correct(runs, start_);
    ++start_;
    arrival_.predict(runs, start_);
    x_ = advance(plant_, x_, runs.step_s(start_), inputs_before(runs, start_));
  }
  const LaneMatrix& root = arrival_.root();

  // In coordinates xi with x_a = x + S xi, the prior is |xi - offset|^2, offset = S^-1 (x_bar - x).
  std::vector<ArrayXd> right(static_cast<std::size_t>(nx_));
  for (Index i = 0; i < nx_; ++i) {
    ArrayXd rest = (arrival_.state().row(i) - x_.row(i)).transpose().array();
    for (Index j = 0; j < i; ++j) rest -= root(i, j) * right[static_cast<std::size_t>(j)];
    right[static_cast<std::size_t>(i)] = rest / root(i, i).max(1e-12);
  }
  LaneMatrix normal(nx_, nx_, lanes_);
  for (Index i = 0; i < nx_; ++i) normal(i, i).setOnes();

  MatrixXd points = x_.replicate(1, nx_ + 1);
  for (Index j = 0; j < nx_; ++j)
    for (Index i = 0; i < nx_; ++i)
      points.row(i).segment((1 + j) * lanes_, lanes_).array() += kSpread * root(i, j).transpose();
  std::vector<ArrayXd> phi(static_cast<std::size_t>(nx_));
  for (Index i = start_;; ++i) {
    const MatrixXd seen = output_at(plant_, points, runs.inputs_at(i));
    for (Index output = 0; output < plant_.ny; ++output) {
      const ArrayXd centre = seen.row(output).head(lanes_).transpose().array();
      const double wrap = plant_.output_wraps[output];
      const auto short_way = [wrap](double d) { return wrap > 0.0 ? wrap_difference(d, wrap) : d; };
      const ArrayXd error = (y_of(i).row(output).transpose().array() - centre).unaryExpr(short_way);
      const ArrayXd& variance = output_variance_[static_cast<std::size_t>(output)];
      const ArrayXd beyond = error.abs() / (gate_ * variance.sqrt());  // 0 if there is no gate
      const auto arrived = error == error;
      const ArrayXd weight = arrived.select((1.0 / (variance * beyond.max(1.0))).eval(), 0.0);
      const ArrayXd pull = arrived.select((weight * error).eval(), 0.0);
      for (Index j = 0; j < nx_; ++j)
        phi[static_cast<std::size_t>(j)] =
            (seen.row(output).segment((1 + j) * lanes_, lanes_).transpose().array() - centre).unaryExpr(short_way) /
            kSpread;
      for (Index j = 0; j < nx_; ++j) {
        const ArrayXd& own = phi[static_cast<std::size_t>(j)];
        right[static_cast<std::size_t>(j)] += pull * own;
        for (Index other = 0; other <= j; ++other)
          normal(j, other) += weight * own * phi[static_cast<std::size_t>(other)];
      }
    }
    if (i == k) break;
    points = advance(plant_, points, runs.step_s(i + 1), inputs_before(runs, i + 1));
  }
  solve_lanes(normal, right);

  MatrixXd now = points.leftCols(lanes_);
  for (Index i = 0; i < nx_; ++i) {
    ArrayXd moved = ArrayXd::Zero(lanes_), start = ArrayXd::Zero(lanes_);
    for (Index j = 0; j < nx_; ++j) {
      const ArrayXd& xi = right[static_cast<std::size_t>(j)];
      moved += xi * (points.row(i).segment((1 + j) * lanes_, lanes_) - points.row(i).head(lanes_)).transpose().array() /
               kSpread;
      start += xi * root(i, j);
    }
    now.row(i) += moved.matrix().transpose();
    x_.row(i) += start.matrix().transpose();
  }
  for (Index lane = 0; lane < lanes_; ++lane) {
    if ((x_.col(lane).array().abs() <= limits_).all() && (now.col(lane).array().abs() <= limits_).all()) continue;
    ++restarts_;
    x_.col(lane) = arrival_.state().col(lane);
    now.col(lane) = x_.col(lane);
  }
  return now;
}

}  // namespace nlo::trainer
