// SPDX-License-Identifier: MIT
// Inputs that act later than their column says: [[log.columns]] delay_s. The log reader converts u to the acting input,
//   u_acting(t) = u(t - delay_s)
// by straight lines between samples. Before the first sample of a run the first value holds. For a command that is held
// over each period and delayed by a part of a period, this is its mean over each period.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/delay_search.h"

namespace nlo::trainer {

/// Returns the column `delay_s` later; time_s and values have N samples.
Eigen::VectorXd delayed(const Eigen::VectorXd& time_s, const Eigen::VectorXd& values, double delay_s);

struct LogDelay {
  std::string input;
  double delay_s = 0.0;
  double sample_period_s = 0.0;  ///< sample period of the observer [s]
  FoundDelay found = {};         ///< in rows of the log

  double samples() const { return delay_s / sample_period_s; }
};

/// Finds the delay of each column with find_delay in the training logs, and writes it into the column. An input that
/// acts earlier than its column shows gets the delay 0. Without such columns no log is read.
///   directory   folder of the logs
///   input_hold  [observer] input_hold, the time at which the u of a sample acts
/// Throws codegen::Error as load_logs does, and with the column's name if the logs do not determine a delay to half a
/// row.
std::vector<LogDelay> find_log_delays(LogConfig& config, const std::string& directory, Hold input_hold);

/// Returns one line for readers: "u acts 0.0125 s (2.5 samples of the observer) later than its column shows (+- 0.02
/// rows; ...)".
std::string to_text(const LogDelay& delay);

/// Returns the required delay of each input in flight, in samples: "u 2.5"; empty if no input is delayed.
std::string delays_in_flight(const LogConfig& config, double sample_period_s);

}  // namespace nlo::trainer
