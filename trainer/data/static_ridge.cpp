// SPDX-License-Identifier: MIT
#include "trainer/data/static_ridge.h"

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/base/ridge.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kBlock = 4096;  // samples at a time, because their products take memory

}  // namespace

MatrixXd StaticRidge::channels_of(const Trajectory& run) const {
  const MatrixXd y = angles_encoded(run.outputs, outputs_);
  MatrixXd both(y.rows() + run.inputs.rows(), run.samples());
  both.topRows(y.rows()) = y;
  if (run.inputs.rows() > 0) both.bottomRows(run.inputs.rows()) = run.inputs;
  return both;
}

MatrixXd StaticRidge::normalised(const Trajectory& run) const {
  return (channels_of(run).colwise() - mean_).array().colwise() / scale_.array();
}

MatrixXd StaticRidge::features_of(const MatrixXd& channels, Index from, Index stride, Index count) const {
  const Index n = channels.rows() * samples_;
  MatrixXd phi(n + n * (n + 1) / 2, count);
  VectorXd c(n);
  for (Index at = 0; at < count; ++at) {
    for (Index back = 0; back < samples_; ++back)
      c.segment(back * channels.rows(), channels.rows()) = channels.col(std::max<Index>(0, from + at * stride - back));
    phi.col(at).head(n) = c;
    Index row = n;
    for (Index i = 0; i < n; ++i) {
      phi.col(at).segment(row, n - i) = c[i] * c.tail(n - i);
      row += n - i;
    }
  }
  return phi;
}

StaticRidge StaticRidge::fit(const Dataset& training, int samples, double ridge) {
  StaticRidge result;
  result.states_ = training.states;
  result.outputs_ = training.outputs;
  result.samples_ = samples;
  double count = 0.0;
  for (const Trajectory& run : training.trajectories) {
    const MatrixXd c = result.channels_of(run);
    if (result.mean_.size() == 0) result.mean_ = result.scale_ = VectorXd::Zero(c.rows());
    result.mean_ += c.rowwise().sum();
    result.scale_ += c.cwiseAbs2().rowwise().sum();
    count += static_cast<double>(run.samples());
  }
  if (count > 0.0) {
    result.mean_ /= count;
    result.scale_ = (result.scale_ / count - result.mean_.cwiseAbs2()).cwiseMax(1e-24).cwiseSqrt();
  }
  // Many channels have many products, and a million samples determine them no better than some thousands.
  constexpr double kWork = 1e10;  // multiply-adds of the normal equations
  const double rows = static_cast<double>(result.mean_.size() * samples), phi = rows + rows * (rows + 1.0) / 2.0;
  const auto stride = std::max<Index>(1, static_cast<Index>(count * phi * phi / kWork));
  Ridge fitted;
  for (const Trajectory& run : training.trajectories) {
    const MatrixXd c = result.normalised(run), x = angles_encoded(run.states, training.states);
    for (Index from = 0; from < run.samples(); from += kBlock * stride) {
      const Index block = std::min(kBlock, (run.samples() - from + stride - 1) / stride);
      const auto some = Eigen::seqN(from, block, stride);
      fitted.add(result.features_of(c, from, stride, block), x(Eigen::all, some), run.weight(some));
    }
  }
  if (!(fitted.weight() > 0.0)) throw codegen::Error("static ridge: no sample to fit it on, or all truth is masked");
  result.weights_ = fitted.fit(ridge);
  return result;
}

MatrixXd StaticRidge::estimate(const Trajectory& run) const {
  const MatrixXd c = normalised(run);
  MatrixXd rows(weights_.rows(), run.samples());
  for (Index from = 0; from < run.samples(); from += kBlock) {
    const Index block = std::min(kBlock, run.samples() - from);
    rows.middleCols(from, block) = weights_ * with_one(features_of(c, from, 1, block));
  }
  return angles_decoded(rows, states_);
}

}  // namespace nlo::trainer
