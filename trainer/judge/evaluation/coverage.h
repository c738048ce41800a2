// SPDX-License-Identifier: MIT
// Measures the reported error of an estimator: the share of the truth within its 68 % and 95 % intervals, and their
// width. A share means nothing without the width, because constant intervals can also contain 68 %.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Estimates, n_x x N, and the half widths of their 68 % and 95 % intervals; 0 x 0 for an estimator without intervals.
struct Estimates {
  Estimates() = default;
  Estimates(Eigen::MatrixXd estimates, Eigen::MatrixXd half_68 = {}, Eigen::MatrixXd half_95 = {})
      : x_hat(std::move(estimates)), sigma(std::move(half_68)), bound_95(std::move(half_95)) {}

  Eigen::MatrixXd x_hat, sigma, bound_95;
};

/// Returns intervals of estimates whose errors are normal with these standard deviations, n_x x N.
Estimates normal_intervals(Eigen::MatrixXd x_hat, const Eigen::MatrixXd& deviations);

/// Values over the samples whose truth counts, n_x each.
struct Coverage {
  Eigen::VectorXd share_68, share_95;  ///< share of the truth in the interval, over samples with an interval; NaN if
                                       ///< there are none
  Eigen::VectorXd sigma;               ///< mean over samples with an interval, in the state's unit
  Eigen::VectorXd unknown;             ///< share of samples without an interval: sigma is kUnknownSigma
};

/// Sums over runs. Adding in the same order gives the same bits.
class CoverageSum {
 public:
  explicit CoverageSum(const std::vector<Channel>& states);

  /// Adds a run. Samples with weight 0 are left out; errors of angles are taken the shorter way round.
  void add(const Trajectory& truth, const Estimates& estimates);
  void merge(const CoverageSum& other);
  std::optional<Coverage> coverage() const;  ///< nothing if no sample counts

 private:
  std::vector<double> wraps_;
  Eigen::VectorXd within_68_, within_95_, sigma_;
  Eigen::VectorXd known_;  ///< weight of samples with an interval, n_x
  double weight_ = 0.0;
};

/// Returns the estimates of a model over a run, with intervals if it has an error head.
Estimates estimates_of(const codegen::Model& model, const codegen::Run& run);

/// Returns estimates with the intervals that the monitor has widened, for a model with an error head and a monitor.
Estimates widened_estimates_of(const codegen::Model& model, const codegen::Run& run);

/// Returns the mean over several evaluations; nothing if one has no coverage.
std::optional<Coverage> mean_coverage(const std::vector<std::optional<Coverage>>& all);

}  // namespace nlo::trainer
