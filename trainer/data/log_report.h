// SPDX-License-Identifier: MIT
// Findings of loading logs: their clock, their rows, and notes, each with its remedy.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "trainer/data/empty_cells.h"
#include "trainer/data/time_stamps.h"
#include "trainer/data/training_logs.h"

namespace nlo::trainer {

/// Adds a note unless it is there already: a note about a column holds for all logs.
void note_once(std::vector<std::string>& notes, const std::string& text);

struct LogReport {
  double sample_period_s = 0.0;  ///< nominal: as configured, otherwise the mean step of the logs, or the median if they
                                 ///< are irregular
  std::vector<TimeStampReport> files;             ///< one for each log, over the runs between its gaps
  std::vector<std::string> notes;                 ///< notes for a reader, each with its remedy
  std::map<std::string, EmptyCells> empty_cells;  ///< by heading, over all files; columns without empty cells are not
                                                  ///< listed
  std::vector<LogContent> contents;               ///< one per file: hashes of its rows, to recognise them
  std::string data_hash;                          ///< content_hash of the files, in the order of `files`
};

/// Returns a table of the time stamps, then the notes in at most 25 lines of 120 columns. report.html has all notes.
std::string to_text(const LogReport& report);

}  // namespace nlo::trainer
