// SPDX-License-Identifier: MIT
// Whether an estimator knows how wrong it is: the share of the truth within its 68 % and 95 % intervals, and how wide
// these are. A share is worth nothing without the width: an estimator may cover 68 % by always saying the same.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/base/noise.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// n_x x N each: an estimate, the half width of its 68 % interval, and that of its 95 % interval.
struct IntervalEstimates {
  Eigen::MatrixXd x_hat, sigma, bound_95;
};

/// Over one run from reset, causal; arguments as those of an Estimator (evaluate.h). Each thread makes its own.
using IntervalEstimator = std::function<IntervalEstimates(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                                          const Eigen::VectorXd& time_s)>;
using IntervalEstimatorFactory = std::function<IntervalEstimator()>;

/// Of estimates whose errors are normal with these standard deviations, n_x x N.
IntervalEstimates normal_intervals(Eigen::MatrixXd x_hat, const Eigen::MatrixXd& deviations);

struct Coverage {
  Eigen::VectorXd share_68, share_95;  ///< n_x, of the samples whose truth counts
  Eigen::VectorXd sigma;               ///< n_x, mean, in the state's unit
};

/// Sums over runs. Adding in the same order gives the same bits.
class CoverageSum {
 public:
  explicit CoverageSum(const std::vector<Channel>& states);

  /// Samples with weight 0 are left out; errors of angles are taken the short way round.
  void add(const Trajectory& truth, const IntervalEstimates& estimates);
  void merge(const CoverageSum& other);
  std::optional<Coverage> coverage() const;  ///< empty when no sample counts

 private:
  std::vector<double> wraps_;
  Eigen::VectorXd within_68_, within_95_, sigma_;
  double weight_ = 0.0;
};

/// On every trajectory of a set with strict noise, as evaluate() has it. The same bytes for any number of threads.
std::optional<Coverage> coverage_on(const IntervalEstimatorFactory& factory, const Dataset& clean,
                                    const NoiseConfig& noise, std::uint64_t seed, int threads);

/// What a model with an error head says over a run.
IntervalEstimates intervals_of(const codegen::Model& model, const codegen::Run& run);
IntervalEstimatorFactory observer_intervals(const codegen::Model& model, bool uniform_steps);

/// The mean over several evaluations; empty when one has none.
std::optional<Coverage> mean_coverage(const std::vector<std::optional<Coverage>>& all);

}  // namespace nlo::trainer
