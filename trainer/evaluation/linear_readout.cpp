// SPDX-License-Identifier: MIT
#include "trainer/evaluation/linear_readout.h"

#include <algorithm>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRidge = 1e-6;  // relative to the features' power: collinear features of fast modes stay harmless

}  // namespace

LinearReadout::LinearReadout(const codegen::Model& model) : states_(model.states) {
  if (const codegen::Network* map = codegen::inverse_map(model)) {
    map_ = map->features;
    mean_ = map->feature_mean;
    scale_ = map->feature_scale;
  } else {
    map_ = MatrixXd::Identity(model.nz() + model.nr(), model.nz() + model.nr());
    mean_ = VectorXd::Zero(map_.rows());
    scale_ = VectorXd::Ones(map_.rows());
  }
  Index targets = 0;
  for (const codegen::Channel& state : states_) targets += state.wrap > 0.0 ? 2 : 1;
  gram_ = MatrixXd::Zero(1 + map_.rows(), 1 + map_.rows());
  cross_ = MatrixXd::Zero(targets, 1 + map_.rows());
}

MatrixXd LinearReadout::features(const codegen::Run& run) const {
  const Index nz = run.z.rows(), ny = run.y.rows();
  MatrixXd u = map_.leftCols(nz) * run.z;
  if (map_.cols() == nz + ny) u += map_.rightCols(ny) * run.y;
  MatrixXd with_one(1 + u.rows(), u.cols());
  with_one.row(0).setOnes();
  with_one.bottomRows(u.rows()) = (u.colwise() - mean_).array().colwise() / scale_.array();
  return with_one;
}

MatrixXd LinearReadout::targets(const MatrixXd& states) const {
  MatrixXd rows(cross_.rows(), states.cols());
  Index next = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const VectorXd state = states.row(static_cast<Index>(i));
    const double wrap = states_[i].wrap;
    if (wrap > 0.0) {
      rows.row(next++) = sine_of(state, wrap).transpose();
      rows.row(next++) = cosine_of(state, wrap).transpose();
    } else {
      rows.row(next++) = state.transpose();
    }
  }
  return rows;
}

void LinearReadout::add(const codegen::Run& run, const Trajectory& truth) {
  const MatrixXd u = features(run);
  // Masked truth may be anything, NaN too: it is set to zero, not only weighted by zero.
  const Eigen::RowVectorXd weight = truth.weight.transpose();
  MatrixXd x = targets(truth.states);
  for (Index k = 0; k < x.cols(); ++k)
    if (weight[k] <= 0.0) x.col(k).setZero();
  const MatrixXd weighted = u.array().rowwise() * weight.array();
  gram_ += weighted * u.transpose();
  cross_ += x * weighted.transpose();
  weight_ += weight.sum();
}

void LinearReadout::fit() {
  if (!(weight_ > 0.0)) throw codegen::Error("linear readout: no sample to fit it on, or all truth is masked");
  const VectorXd power = (gram_.diagonal() / weight_).cwiseMax(1e-300).cwiseSqrt();
  MatrixXd normal = (gram_ / weight_).array() / (power * power.transpose()).array();
  normal.diagonal().tail(normal.rows() - 1).array() += kRidge;
  const MatrixXd right = (cross_ / weight_).array().rowwise() / power.transpose().array();
  weights_ = codegen::solve_symmetric(normal, right.transpose()).transpose();
  weights_ = (weights_.array().rowwise() / power.transpose().array()).eval();
}

MatrixXd LinearReadout::estimate(const codegen::Run& run) const {
  const MatrixXd rows = weights_ * features(run);
  MatrixXd x_hat(static_cast<Index>(states_.size()), rows.cols());
  Index next = 0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const double wrap = states_[i].wrap;
    if (wrap > 0.0) {
      x_hat.row(static_cast<Index>(i)) =
          angle_of(rows.row(next).transpose(), rows.row(next + 1).transpose(), wrap).transpose();
      next += 2;
    } else {
      x_hat.row(static_cast<Index>(i)) = rows.row(next++);
    }
  }
  return x_hat;
}

}  // namespace nlo::trainer
