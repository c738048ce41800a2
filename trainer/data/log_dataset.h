// SPDX-License-Identifier: MIT
// Reads CSV logs of a real rig into a Dataset: each stretch between gaps is a run, with columns as channels, angles
// unwrapped, velocities by the zero-phase filter, and time from the first sample. A LogReport lists the findings.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_report.h"
#include "trainer/data/training_logs.h"

namespace nlo::trainer {

/// Loads the logs that match `files` (names or globs below `directory`; empty: as given). A log is split at steps that
/// exceed max_gap_s. In each run time begins at 0. A run that is too short for the filter and its masks is dropped.
///   outputs  n_y x N  as measured, angles unwrapped from their first sample (or as sine and cosine); an empty cell
///   holds the last value, and is `missing`
///   states   n_x x N  converted like the outputs; with `derivative_of` the zero-phase velocity of another column;
///   empty cells are on straight lines
///   weight   N        0 within mask_edges_s of either end if a state is such a velocity, else 1; 0 if the cell of a
///   state is empty, and for a velocity also within mask_edges_s of a hole longer than 1 / cutoff_hz
///   time_s   N        from the first sample; on the even grid if stamps differ from it by their rounding
///   uniform           true if every run is regular (TimeGrid), of the nominal period, and complete
/// With `every` = n > 1 all of this is computed from every row, then each n-th sample is kept. Columns that are not
/// listed are not read. Throws codegen::Error with file, line and column: see CsvTable, resolve_columns, expand_files,
/// read_log; and for a log without a run that is long enough.
Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report = nullptr);

struct LogSplits {
  Dataset train, validation, test;  ///< an empty split has channels and no trajectories
  LogReport report;                 ///< report on all three, in that order
  TrainingLogs remembered;          ///< facts about the training logs that the model stores
};

/// Returns the three splits of `config`, checked to be disjoint. With `every` = n, training gets n runs of each log,
/// which begin at its first n rows. All splits use the nominal sample period of the training logs.
/// `mirrored`: channels that change their sign in mirror images of runs (mirror.h). The mirror images widen the ranges
/// of the outputs in training.
LogSplits load_log_splits(const LogConfig& config, const std::string& directory,
                          const std::vector<std::string>& mirrored = {});

}  // namespace nlo::trainer
