// SPDX-License-Identifier: MIT
// How far estimates are from the truth on logs: RMSE per state over three windows, since a rig at rest dilutes the
// whole and the transient hides the rest. Angles are compared the short way round; masked samples do not count.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Time from the first sample of a log.
struct ErrorWindow {
  const char* name;
  double from_s, to_s;  ///< from_s <= t < to_s
};

inline constexpr std::array<ErrorWindow, 3> kErrorWindows = {
    {{"all", 0.0, 1e300}, {"after 2 s", 2.0, 1e300}, {"0.5-5 s", 0.5, 5.0}}};

/// One state, or one angle made of the states NAME_sin and NAME_cos.
struct StateError {
  std::string name, unit;
  std::array<double, kErrorWindows.size()> rmse{};  ///< per window; NaN: no sample counts, or no estimate was made
};

struct LogMetrics {
  struct File {
    std::string source;
    std::vector<StateError> states;
  };
  std::vector<File> files;
  std::vector<StateError> pooled;  ///< over the samples of all files together
};

/// Errors of `estimates` (n_x x N each, one per trajectory). After the states come the angles of `angle_pairs`
/// (LogSchema::angle_pairs), by atan2. Throws codegen::Error when a shape does not fit.
LogMetrics log_metrics(const Dataset& data, const std::vector<Eigen::MatrixXd>& estimates,
                       const std::vector<AnglePair>& angle_pairs = {});

}  // namespace nlo::trainer
