// SPDX-License-Identifier: MIT
// CSV logs of a real rig as a Dataset: one run between gaps each, columns to channels, angles unwrapped, velocities by
// the zero-phase filter, time from the first sample. What was found on the way (clock, notes) is a LogReport.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_report.h"
#include "trainer/data/training_logs.h"

namespace nlo::trainer {

/// Loads the logs that match `files` (names or globs below `directory`; empty: as they stand). A log is split where a
/// step exceeds max_gap_s; each run starts anew, and one that is too short for the filter and its masks is dropped.
///   outputs  n_y x N  as measured, angles unwrapped from their first sample (or as sine and cosine); an empty cell
///                     holds the value before it, and is `missing`
///   states   n_x x N  columns likewise; `derivative_of` another: its zero-phase velocity; empty cells on
///                     straight lines
///   weight   N        0 within mask_edges_s of either end when a state is such a velocity, else 1; 0 where the cell of
///                     a state is empty, and for a velocity also within mask_edges_s of a hole longer than
///                     1 / cutoff_hz
///   time_s   N        from the first sample; on the even grid where stamps differ from it by their rounding
///   uniform           every run is regular (TimeGrid), of the nominal period, and misses no sample
/// With `every` = n > 1 all of that is computed from every row, then each n-th sample is kept. Columns not listed are
/// not read. Throws codegen::Error naming file, line and column: see CsvTable, resolve_columns, expand_files, read_log;
/// a log none of whose runs is long enough.
Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report = nullptr);

struct LogSplits {
  Dataset train, validation, test;  ///< an empty split has channels and no trajectories
  LogReport report;                 ///< report of all three, in that order
  TrainingLogs remembered;          ///< facts about the training logs for the model
};

/// The three splits of `config`, checked to be disjoint; with `every` = n, training gets n runs of each log, which
/// begin at its first n rows. All are on one nominal sample period: that of the training logs.
/// `mirrored`: channels that change their sign in mirror images of runs (mirror.h). The images widen the range of the
/// outputs that training sees.
LogSplits load_log_splits(const LogConfig& config, const std::string& directory,
                          const std::vector<std::string>& mirrored = {});

}  // namespace nlo::trainer
