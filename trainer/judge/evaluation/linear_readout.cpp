// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/linear_readout.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRidge = 1e-6;  // for collinear features of fast modes

}  // namespace

LinearReadout::LinearReadout(const codegen::Model& model, double settled_from_s)
    : LinearReadout(model, model.states, settled_from_s) {}

LinearReadout::LinearReadout(const codegen::Model& model, std::vector<codegen::Channel> states, double settled_from_s)
    : states_(std::move(states)),
      settled_from_(static_cast<Index>(std::lround(std::min(settled_from_s / model.sample_period_s, 1e9)))) {
  if (const codegen::Network* map = codegen::inverse_map(model)) {
    map_ = map->features;
    mean_ = map->feature_mean;
    scale_ = map->feature_scale;
    clocks_ = map->feature_clocks;
  } else {
    map_ = MatrixXd::Identity(model.nz() + model.nr(), model.nz() + model.nr());
    mean_ = VectorXd::Zero(map_.rows());
    scale_ = VectorXd::Ones(map_.rows());
  }
}

MatrixXd LinearReadout::features(const codegen::Run& run) const {
  const Index nz = run.z.rows(), ny = run.y.rows();
  MatrixXd u = map_.leftCols(nz) * run.z;
  if (map_.cols() == nz + ny) u += map_.rightCols(ny) * run.y;
  u = ((u.colwise() - mean_).array().colwise() / scale_.array()).matrix();
  codegen::multiply_by_clocks(u, run.z, clocks_);
  return u;
}

void LinearReadout::add(const codegen::Run& run, const Trajectory& truth) {
  const MatrixXd states = angles_encoded(truth.states, states_);
  if (clocks_.empty()) {
    const MatrixXd u = features(run);
    ridge_.add(u, states, truth.weight);
    const Index settled = std::max<Index>(u.cols() - settled_from_, 0);
    if (settled_from_ > 0 && settled > 0)
      settled_.add(u.rightCols(settled), states.rightCols(settled), truth.weight.tail(settled));
    return;
  }
  std::vector<int> since_start(static_cast<std::size_t>(run.z.cols()));
  std::iota(since_start.begin(), since_start.end(), 0);
  of_products_.add(features(run), states, truth.weight, since_start);
}

void LinearReadout::fit() {
  if (!(ridge_.weight() + of_products_.weight() > 0.0))
    throw codegen::Error("linear readout: there is no sample with a known truth for the fit; unmask some samples");
  weights_ = clocks_.empty() ? ridge_.fit(kRidge) : of_products_.fit(kRidge);
  if (settled_.weight() > 0.0) settled_weights_ = settled_.fit(kRidge);
}

MatrixXd LinearReadout::estimate(const codegen::Run& run) const {
  const MatrixXd u = with_one(features(run));
  MatrixXd estimate = weights_ * u;
  const Index settled = std::max<Index>(u.cols() - settled_from_, 0);
  if (settled_weights_.size() > 0) estimate.rightCols(settled) = settled_weights_ * u.rightCols(settled);
  return angles_decoded(estimate, states_);
}

}  // namespace nlo::trainer
