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

/// Notes are kept in order and once each: one about a column holds for all logs.
void note_once(std::vector<std::string>& notes, const std::string& text);

struct LogReport {
  double sample_period_s = 0.0;        ///< nominal: as configured, else the logs' mean step, or median if irregular
  std::vector<TimeStampReport> files;  ///< one for each log, over the runs that gaps make of it
  std::vector<std::string> notes;      ///< notes for a reader, each with its remedy
  std::map<std::string, EmptyCells> empty_cells;  ///< by heading, over all files; none where there are none
  std::vector<LogContent> contents;               ///< one per file: its rows, to be found again
  std::string data_hash;                          ///< content_hash of the files, in the order of `files`
};

/// Table of the time stamps, then the notes in at most 25 lines of 120 columns. report.html has all of them.
std::string to_text(const LogReport& report);

}  // namespace nlo::trainer
