// SPDX-License-Identifier: MIT
// Whether an estimator knows how wrong it is: the share of the truth within its 68 % and 95 % intervals, and how wide
// these are. A share is worth nothing without the width: an estimator may cover 68 % by always saying the same.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// n_x x N each: estimates and, of an estimator that knows how wrong it is, the half widths of its 68 % and 95 %
/// intervals; else 0 x 0.
struct Estimates {
  Estimates() = default;
  Estimates(Eigen::MatrixXd estimates, Eigen::MatrixXd half_68 = {}, Eigen::MatrixXd half_95 = {})
      : x_hat(std::move(estimates)), sigma(std::move(half_68)), bound_95(std::move(half_95)) {}

  Eigen::MatrixXd x_hat, sigma, bound_95;
};

/// Intervals of estimates whose errors are normal with these standard deviations, n_x x N.
Estimates normal_intervals(Eigen::MatrixXd x_hat, const Eigen::MatrixXd& deviations);

/// n_x each, of the samples whose truth counts.
struct Coverage {
  Eigen::VectorXd share_68, share_95;  ///< truth in the interval, of those with an interval; NaN if none has
  Eigen::VectorXd sigma;               ///< mean over those with an interval, in the state's unit
  Eigen::VectorXd unknown;             ///< share of those without: sigma is kUnknownSigma
};

/// Sums over runs. Adding in the same order gives the same bits.
class CoverageSum {
 public:
  explicit CoverageSum(const std::vector<Channel>& states);

  /// Samples with weight 0 are left out; errors of angles are taken the short way round.
  void add(const Trajectory& truth, const Estimates& estimates);
  void merge(const CoverageSum& other);
  std::optional<Coverage> coverage() const;  ///< empty when no sample counts

 private:
  std::vector<double> wraps_;
  Eigen::VectorXd within_68_, within_95_, sigma_;
  Eigen::VectorXd known_;  ///< weight of samples with an interval, n_x
  double weight_ = 0.0;
};

/// Estimates of a model over a run, with intervals if it has an error head.
Estimates estimates_of(const codegen::Model& model, const codegen::Run& run);

/// Estimates with the intervals that the monitor has widened, for a model with an error head and a monitor.
Estimates widened_estimates_of(const codegen::Model& model, const codegen::Run& run);

/// The mean over several evaluations; empty when one has none.
std::optional<Coverage> mean_coverage(const std::vector<std::optional<Coverage>>& all);

}  // namespace nlo::trainer
