// SPDX-License-Identifier: MIT
#include "trainer/base/ridge.h"

#include <cmath>

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd with_one(const MatrixXd& u) {
  MatrixXd result(1 + u.rows(), u.cols());
  result.row(0).setOnes();
  result.bottomRows(u.rows()) = u;
  return result;
}

void Ridge::begin(Index columns, Index states) {
  if (gram_.size() != 0) return;
  gram_ = MatrixXd::Zero(columns, columns);
  cross_ = MatrixXd::Zero(states, columns);
  squares_ = VectorXd::Zero(states);
}

void Ridge::add(const MatrixXd& u, const MatrixXd& x, const VectorXd& weights) {
  const MatrixXd rows = with_one(u);
  begin(rows.rows(), x.rows());
  MatrixXd known = x;
  for (Index k = 0; k < x.cols(); ++k)  // NaN times a weight of zero would be NaN
    if (weights[k] <= 0.0) known.col(k).setZero();
  const MatrixXd weighted = rows.array().rowwise() * weights.transpose().array();
  gram_ += weighted * rows.transpose();
  cross_ += known * weighted.transpose();
  squares_ += known.cwiseAbs2() * weights;
  weight_ += weights.sum();
}

void Ridge::add(const Ridge& other, double share) {
  begin(other.gram_.rows(), other.cross_.rows());
  gram_ += share * other.gram_;
  cross_ += share * other.cross_;
  squares_ += share * other.squares_;
  weight_ += share * other.weight_;
}

VectorXd Ridge::squared_errors(const MatrixXd& w) const {
  const VectorXd squares =
      squares_ - 2.0 * w.cwiseProduct(cross_).rowwise().sum() + (w * gram_).cwiseProduct(w).rowwise().sum();
  return squares.cwiseMax(0.0) / weight_;
}

void TransientRidge::add(const MatrixXd& u, const MatrixXd& x, const VectorXd& weights,
                         const std::vector<int>& since_start) {
  constexpr double kBinsOfAnOctave = 3.0;
  std::vector<std::vector<Index>> columns;
  for (Index k = 0; k < u.cols(); ++k) {
    const int time = since_start[static_cast<std::size_t>(k)];
    const auto bin = static_cast<std::size_t>(kBinsOfAnOctave * std::log2(1.0 + time));
    if (bin >= columns.size()) columns.resize(bin + 1);
    columns[bin].push_back(k);
  }
  if (bins_.size() < columns.size()) bins_.resize(columns.size());
  for (std::size_t bin = 0; bin < columns.size(); ++bin)
    if (!columns[bin].empty())
      bins_[bin].add(u(Eigen::all, columns[bin]), x(Eigen::all, columns[bin]), weights(columns[bin]));
}

double TransientRidge::weight() const {
  double sum = 0.0;
  for (const Ridge& bin : bins_) sum += bin.weight();
  return sum;
}

MatrixXd TransientRidge::fit(double ridge) const {
  constexpr int kFits = 4;
  constexpr double kLeast = 1e-3;  // deviations of a state
  std::vector<const Ridge*> bins;  // bins that have weight
  Ridge all;
  for (const Ridge& bin : bins_) {
    if (!(bin.weight() > 0.0)) continue;
    bins.push_back(&bin);
    all.add(bin, 1.0);
  }
  MatrixXd w = all.fit(ridge);
  MatrixXd constant = MatrixXd::Zero(w.rows(), w.cols());
  constant.col(0) = all.mean();
  const VectorXd least = kLeast * kLeast * all.squared_errors(constant);
  for (int fit = 1; fit < kFits; ++fit) {
    std::vector<VectorXd> errors;
    for (const Ridge* bin : bins) errors.push_back(bin->squared_errors(w));
    for (Index i = 0; i < w.rows(); ++i) {
      Ridge relative;
      for (std::size_t bin = 0; bin < bins.size(); ++bin)
        relative.add(*bins[bin], 1.0 / (errors[bin](i) + least(i) + 1e-300) / bins[bin]->weight());
      w.row(i) = relative.fit(ridge).row(i);
    }
  }
  return w;
}

MatrixXd Ridge::fit(double ridge) const {
  const VectorXd power = (gram_.diagonal() / weight_).cwiseMax(1e-300).cwiseSqrt();
  MatrixXd normal = (gram_ / weight_).array() / (power * power.transpose()).array();
  normal.diagonal().tail(normal.rows() - 1).array() += ridge;
  const MatrixXd right = (cross_ / weight_).array().rowwise() / power.transpose().array();
  const MatrixXd weights = codegen::solve_symmetric(normal, right.transpose()).transpose();
  return weights.array().rowwise() / power.transpose().array();
}

}  // namespace nlo::trainer
