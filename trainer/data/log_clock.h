// SPDX-License-Identifier: MIT
// The clock of several logs: the runs between their gaps, and the common nominal period.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/log_file.h"

namespace nlo::trainer {

using LogRuns = std::vector<std::vector<LogRun>>;  ///< runs of each file

/// Splits each log at steps that exceed max_gap_s, or kGapPeriods usual periods if it is not given.
LogRuns split_logs(const LogConfig& config, const std::vector<LogFile>& logs, std::vector<std::string>& notes);

/// Returns the configured period. Otherwise, for regular logs with one clock, the mean step over all logs, which does
/// not drift; for other logs the median.
double nominal_period(const LogConfig& config, const LogRuns& runs);

/// Adds a note if a log has another clock than the nominal one; such a log is used with its stamps, which is slower.
/// Throws codegen::Error if the periods differ by so much that a wrong unit of time is likely.
void check_period(const LogFile& log, const LogRun& run, double nominal_s, std::vector<std::string>& notes);

}  // namespace nlo::trainer
