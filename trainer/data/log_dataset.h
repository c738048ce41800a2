// SPDX-License-Identifier: MIT
// CSV logs of a real rig as a Dataset: columns to channels, angles unwrapped, velocities by the zero-phase filter, time
// from the first sample. What was found on the way (clock jitter, notes) is a LogReport.
#pragma once

#include <string>
#include <vector>

#include "trainer/config.h"
#include "trainer/data/dataset.h"
#include "trainer/data/time_stamps.h"

namespace nlo::trainer {

struct LogReport {
  double sample_period_s = 0.0;  ///< nominal: as configured, else the median step of the logs
  std::vector<TimeStampReport> files;
  std::vector<std::string> notes;  ///< what a reader should know: inputs that are not used, suspicious angles
  std::string data_hash;           ///< content_hash of the files, in the order of `files`
};

/// Table of the time stamps, then the notes, one per line.
std::string to_text(const LogReport& report);

/// Loads the logs that match `files` (names or globs below `directory`; empty: as they stand).
///   outputs  n_y x N  as measured, angles unwrapped from their first sample (or as sine and cosine)
///   states   n_x x N  columns likewise; `derivative_of` another: its zero-phase velocity
///   weight   N        0 within mask_edges_s of either end when a state is such a velocity, else 1
///   time_s   N        from the first sample; without a time column multiples of sample_period_s, and `uniform`
/// Inputs are checked and noted, not kept: observers of driven plants come later. Columns not listed are not read.
/// Throws codegen::Error naming file, line and column: see CsvTable, resolve_columns, expand_files; time stamps that do
/// not increase; a log too short for the filter or all masked.
Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report = nullptr);

struct LogSplits {
  Dataset train, validation, test;  ///< an empty split has channels and no trajectories
  LogReport report;                 ///< of all three, in that order
};

/// The three splits of `config`, checked to be disjoint, on one nominal sample period: that of the training logs.
LogSplits load_log_splits(const LogConfig& config, const std::string& directory);

}  // namespace nlo::trainer
