// SPDX-License-Identifier: MIT
// Parameters of a plant from logs: least squares over the segments of a ShootingProblem by Levenberg and Marquardt's
// method (Eigen's, after MINPACK), with standard errors.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "trainer/base/parallel.h"
#include "trainer/config/identification.h"
#include "trainer/data/dataset.h"
#include "trainer/identify/shooting.h"

namespace nlo::trainer {

struct ParameterEstimate {
  std::string name;
  double start = 0.0, value = 0.0;
  /// sqrt of the diagonal of s^2 (J'J)^-1, s^2 = |r|^2 / degrees of freedom: right for white residuals.
  double standard_error = 0.0;
  /// sqrt of the diagonal of (J'J)^-1 (sum over segments of g g') (J'J)^-1, g = J_s' r_s. Right for many segments whose
  /// residuals are correlated within a segment, as for a model that differs from the rig. White 1980; Liang, Zeger
  /// 1986.
  double clustered_error = 0.0;
  bool fixed = false, at_bound = false;
  bool unidentified = false;  ///< the data do not tell it: it belongs to a direction without effect on the residuals
};

struct FittedError {
  std::string name, unit;
  double rmse = 0.0;         ///< over segments, each from its best initial state
  double correlation = 0.0;  ///< correlation of neighbouring residuals; 0 for a model that is as good as its noise
};

struct IdentificationResult {
  std::vector<ParameterEstimate> parameters;
  Eigen::VectorXd values;  ///< p, n_p
  Eigen::Index segments = 0, samples = 0, residuals = 0;
  double degrees_of_freedom = 0.0;  ///< residuals - parameters - initial states that the measurements tell
  double residual_deviation = 0.0;  ///< s; 1 where [identify] noise is right
  double condition = 0.0;           ///< condition number of J with columns of unit length
  int iterations = 0;
  std::string outcome;  ///< "converged", "stopped", "not converged in 50 iterations"
  bool stopped = false;
  std::vector<FittedError> training, test;  ///< empty test: no test logs
};

/// Called after each iteration: how many, and s.
using IdentifyProgress = std::function<void(int iteration, double residual_deviation)>;

/// Finds the parameters on `training`; `test` is only simulated. A parameter is unidentified where J, its columns
/// scaled to unit length, has a singular value below 1e-7 of the largest in whose direction it has a share above .1.
/// `stop`: the best parameters so far are kept. Throws codegen::Error when the plant cannot
/// be simulated from where it starts.
IdentificationResult identify(const Identification& identification, const Dataset& training, const Dataset& test,
                              ThreadPool& pool, const std::atomic<bool>* stop = nullptr,
                              const IdentifyProgress& progress = {});

}  // namespace nlo::trainer
