// SPDX-License-Identifier: MIT
#include "trainer/baselines/static_ridge.h"

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/base/ridge.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows of `values`; those of an angle as sine and cosine.
MatrixXd encoded(const MatrixXd& values, const std::vector<Channel>& channels) {
  std::vector<VectorXd> rows;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const VectorXd row = values.row(static_cast<Index>(i));
    if (channels[i].wrap > 0.0) {
      rows.push_back(sine_of(row, channels[i].wrap));
      rows.push_back(cosine_of(row, channels[i].wrap));
    } else {
      rows.push_back(row);
    }
  }
  MatrixXd result(static_cast<Index>(rows.size()), values.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) result.row(static_cast<Index>(i)) = rows[i].transpose();
  return result;
}

}  // namespace

MatrixXd StaticRidge::channels_of(const Trajectory& run) const {
  const MatrixXd y = encoded(run.outputs, outputs_);
  MatrixXd both(y.rows() + run.inputs.rows(), run.samples());
  both.topRows(y.rows()) = y;
  if (run.inputs.rows() > 0) both.bottomRows(run.inputs.rows()) = run.inputs;
  return both;
}

MatrixXd StaticRidge::features_of(const Trajectory& run) const {
  const MatrixXd now = (channels_of(run).colwise() - mean_).array().colwise() / scale_.array();
  const Index n = now.rows() * samples_;
  MatrixXd phi(n + n * (n + 1) / 2, run.samples());
  VectorXd c(n);
  for (Index k = 0; k < run.samples(); ++k) {
    for (Index back = 0; back < samples_; ++back)
      c.segment(back * now.rows(), now.rows()) = now.col(std::max<Index>(0, k - back));
    phi.col(k).head(n) = c;
    Index at = n;
    for (Index i = 0; i < n; ++i) {
      phi.col(k).segment(at, n - i) = c[i] * c.tail(n - i);
      at += n - i;
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
  Ridge fitted;
  for (const Trajectory& run : training.trajectories)
    fitted.add(result.features_of(run), encoded(run.states, training.states), run.weight);
  if (!(fitted.weight() > 0.0)) throw codegen::Error("static ridge: no sample to fit it on, or all truth is masked");
  result.weights_ = fitted.fit(ridge);
  return result;
}

MatrixXd StaticRidge::estimate(const Trajectory& run) const {
  const MatrixXd rows = weights_ * with_one(features_of(run));
  MatrixXd x_hat(static_cast<Index>(states_.size()), run.samples());
  Index next = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    if (states_[i].wrap > 0.0) {
      x_hat.row(row) =
          angle_of(rows.row(next).transpose(), rows.row(next + 1).transpose(), states_[i].wrap).transpose();
      next += 2;
    } else {
      x_hat.row(row) = rows.row(next++);
    }
  }
  return x_hat;
}

}  // namespace nlo::trainer
