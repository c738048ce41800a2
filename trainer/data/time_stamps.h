// SPDX-License-Identifier: MIT
// How regular the clock of a log is: what the loader found in its time stamps, for the report.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace nlo::trainer {

/// Statistics of the steps between the time stamps of one log.
struct TimeStampReport {
  std::string file;
  Eigen::Index samples = 0;
  double duration_s = 0.0;
  double median_s = 0.0, p01_s = 0.0, p99_s = 0.0, max_s = 0.0;
  int gaps = 0;  ///< steps longer than 1.5 nominal periods
};

/// `time_s` has at least two samples and increases.
TimeStampReport report_time_stamps(const std::string& file, const Eigen::VectorXd& time_s, double nominal_s);

/// Median of the steps of several logs taken together.
double median_step(const std::vector<Eigen::VectorXd>& times_s);

}  // namespace nlo::trainer
