// SPDX-License-Identifier: MIT
// Errors of estimates on logs: RMSE per state over windows of time, because time at rest makes the error over the whole
// log small, and the transient makes it large. Angles are compared the shorter way round; masked samples do not count.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/evaluation_windows.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// One state, or one angle that consists of the states NAME_sin and NAME_cos.
struct StateError {
  std::string name, unit;
  std::vector<double> rmse;  ///< per window; NaN: no sample counts, or there is no estimate
};

struct LogMetrics {
  struct File {
    std::string source;
    std::vector<StateError> states;
  };
  EvaluationWindows windows;       ///< "all" first
  std::vector<File> files;         ///< one for each log, also if gaps split it into several runs
  std::size_t runs = 0;            ///< sum over all files
  std::vector<StateError> pooled;  ///< over the samples of all files together
};

/// Returns the errors of `estimates` (n_x x N each, one per trajectory). After the states come the angles of
/// `angle_pairs` (LogSchema::angle_pairs), by atan2. Windows count the time from the first sample of a log. Throws
/// codegen::Error if a shape is wrong.
LogMetrics log_metrics(const Dataset& data, const std::vector<Eigen::MatrixXd>& estimates,
                       const std::vector<AnglePair>& angle_pairs = {}, const EvaluationWindows& windows = whole_run());

}  // namespace nlo::trainer
