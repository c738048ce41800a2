// SPDX-License-Identifier: MIT
// Reads the clock of a log: numbers or times of day. Loggers repeat a stamp, write a wrong one, start again or
// overflow. Rows with a doubtful stamp are left out; a clock that goes back begins a new run.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/data/csv.h"

namespace nlo::trainer {

/// A step of more usual periods is a gap.
inline constexpr double kGapPeriods = 10.0;

struct LogStamps {
  std::vector<Eigen::Index> rows;  ///< rows of the table that are kept
  /// Time of the kept rows since the first [s], increasing. Where the clock goes back, a usual step is inserted.
  Eigen::VectorXd time_s;
  std::vector<Eigen::Index> restarts;  ///< kept rows (from 0) at which the clock has gone back, increasing
  double start_s = 0.0;                ///< first stamp; 0 for times of day
  double resolution_s = 0.0;           ///< resolution of the printed stamps (stamp_resolution)
  bool is_text = false;                ///< times of day: `unit_s` is not used
  std::vector<std::string> notes;      ///< repeated and wrong stamps, restarts, each with file and line
};

/// Reads the cells under `heading`, numbers of `unit_s` seconds or times of day (clock_text.h).
///   repeated stamps   the first row is kept
///   wrong stamps      one or a few that do not fit between their neighbours, while these fit each other: left out
///   a step back       a new run; but time continues at midnight of times without a date, and where an integer of 16 or
///   32 bits overflows
/// Throws codegen::Error if a stamp is neither a number nor a time of day, if time increases in no or few steps, or if
/// many rows share their stamps with other readings (a clock too coarse).
LogStamps read_stamps(const CsvTable& table, const std::string& heading, double unit_s);

}  // namespace nlo::trainer
