// SPDX-License-Identifier: MIT
// Matrices of intervals, whose arithmetic is rounded outwards (codegen/model/expression_values.h).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "codegen/model/expression_values.h"

namespace nlo::trainer {

using codegen::Interval;

/// Returns an interval that contains middle +- radius.
inline Interval around(double middle, double radius) {
  return Interval(middle) + Interval(-radius, radius);
}
inline double most(const Interval& a) {
  return std::max(std::abs(a.low), std::abs(a.high));
}

class IntervalMatrix {
 public:
  IntervalMatrix() = default;
  explicit IntervalMatrix(Eigen::Index rows, Eigen::Index cols = 1)
      : rows_(rows), cols_(cols), values_(static_cast<std::size_t>(rows * cols)) {}

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  Interval& operator()(Eigen::Index i, Eigen::Index j = 0) { return values_[static_cast<std::size_t>(i + j * rows_)]; }
  const Interval& operator()(Eigen::Index i, Eigen::Index j = 0) const {
    return values_[static_cast<std::size_t>(i + j * rows_)];
  }

  Eigen::MatrixXd middle() const {
    return entries([](const Interval& v) { return 0.5 * (v.low + v.high); });
  }
  /// Returns for each interval the largest distance of its numbers from middle().
  Eigen::MatrixXd radius() const {
    return entries([](const Interval& v) { return most(v - Interval(0.5 * (v.low + v.high))); });
  }
  Eigen::MatrixXd largest() const { return entries(most); }

 private:
  template <class Function>
  Eigen::MatrixXd entries(const Function& function) const {
    return Eigen::MatrixXd::NullaryExpr(rows_, cols_,
                                        [&](Eigen::Index i, Eigen::Index j) { return function((*this)(i, j)); });
  }

  Eigen::Index rows_ = 0, cols_ = 0;
  std::vector<Interval> values_;  ///< column by column
};

}  // namespace nlo::trainer
