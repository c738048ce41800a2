// SPDX-License-Identifier: MIT
// The clock of several logs: the runs between their gaps, and the one period that all of them are said to have.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/log_file.h"

namespace nlo::trainer {

using LogRuns = std::vector<std::vector<LogRun>>;  ///< runs of each file

/// Splits each log where a step exceeds max_gap_s, or without that many usual periods.
LogRuns split_logs(const LogConfig& config, const std::vector<LogFile>& logs, std::vector<std::string>& notes);

/// Returns the configured period. Else, for regular logs of one clock, their mean step over all logs, which does not
/// drift; for others the median.
double nominal_period(const LogConfig& config, const LogRuns& runs);

/// A log on another clock than the nominal one is used as it is stamped, and slowly: noted. Throws codegen::Error where
/// the periods differ by more than a unit of time would explain.
void check_period(const LogFile& log, const LogRun& run, double nominal_s, std::vector<std::string>& notes);

}  // namespace nlo::trainer
