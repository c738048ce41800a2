// SPDX-License-Identifier: MIT
// Finds logged states that are the velocity of a logged output, and their delay. Rigs log causal differences of their
// encoders, which are low-passed and late. An observer that learns such a state is late, too.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

struct VelocityMatch {
  double lag_samples = 0.0;  ///< > 0: the signal is late; resolved to a fraction of a sample
  double correlation = 0.0;  ///< correlation at that lag
  double gain = 1.0;         ///< signal per velocity at that lag
};

/// Returns the lag with the largest correlation of `signal` and `velocity` (N each), within `max_lag` samples either
/// way. Nothing if the lag is at an end, if one of the signals rests, or if there are fewer than 10 max_lag samples.
std::optional<VelocityMatch> match_velocity(const Eigen::VectorXd& signal, const Eigen::VectorXd& velocity,
                                            int max_lag);

/// Compares each state of the file with the zero-phase velocity of each output, on the longest run.
void note_logged_velocities(const LogSchema& schema, const VelocityFilterConfig& filter,
                            const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs,
                            double sample_period_s, std::vector<std::string>& notes);

}  // namespace nlo::trainer
