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
  /// sqrt of the diagonal of s^2 (J'J)^-1, s^2 = |r|^2 / degrees of freedom. Valid for white residuals.
  double standard_error = 0.0;
  /// sqrt of the diagonal of (J'J)^-1 (sum over segments of g g') (J'J)^-1, g = J_s' r_s. Valid for many segments whose
  /// residuals are correlated within a segment, as for a model that differs from the rig. White 1980; Liang, Zeger
  /// 1986.
  double clustered_error = 0.0;
  bool fixed = false, at_bound = false;
  /// True if the data do not determine the parameter: it belongs to a direction that does not affect the residuals.
  bool unidentified = false;
};

struct FittedError {
  std::string name, unit;
  double rmse = 0.0;         ///< RMSE over segments, each from its best initial state
  double correlation = 0.0;  ///< correlation of neighbouring residuals; near 0 if the errors are only noise
};

struct IdentificationResult {
  std::vector<ParameterEstimate> parameters;
  Eigen::VectorXd values;  ///< p, n_p
  Eigen::Index segments = 0, samples = 0, residuals = 0;
  double degrees_of_freedom = 0.0;  ///< residuals - parameters - initial states that the measurements determine
  double residual_deviation = 0.0;  ///< s; 1 if [identify] noise is right
  double condition = 0.0;           ///< condition number of J with columns of unit length
  int iterations = 0;
  std::string outcome;  ///< "converged", "stopped", "not converged in 50 iterations"
  bool stopped = false;
  std::vector<FittedError> training, test;  ///< empty test: no test logs
};

/// Called after each iteration with its number and s.
using IdentifyProgress = std::function<void(int iteration, double residual_deviation)>;

/// Finds the parameters on `training`; `test` is only simulated. The columns of J are scaled to unit length. A
/// parameter is unidentified if its share is above .1 in a singular direction of J whose singular value is below 1e-7
/// of the largest. `stop`: returns the best parameters so far. Throws codegen::Error if the plant cannot be simulated
/// from the start values.
IdentificationResult identify(const Identification& identification, const Dataset& training, const Dataset& test,
                              ThreadPool& pool, const std::atomic<bool>* stop = nullptr,
                              const IdentifyProgress& progress = {});

}  // namespace nlo::trainer
