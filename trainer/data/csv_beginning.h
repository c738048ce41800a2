// SPDX-License-Identifier: MIT
// Finds the beginning of the table in a file. Loggers and spreadsheets write lines about themselves above the headings,
// and units below them.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "trainer/data/csv_records.h"

namespace nlo::trainer {

struct CsvBeginning {
  std::size_t header = 0;               ///< records above the headings
  std::size_t skipped = 0;              ///< records between the headings and the first row: blank, or the units
  std::vector<std::string_view> units;  ///< one for each heading, without brackets; empty: there is no such row
};

/// Finds the first rows of numbers that have as many cells as most records at the beginning of the file, and the
/// headings above them: a record of as many cells without a number. A record below the headings is the row of units if
/// most of its cells are in the table of units. If there are no such headings, the first record that is not blank is
/// used.
///   records  at the beginning of the file
///   decimal  decimal mark of numbers
CsvBeginning find_beginning(CsvRecords records, char decimal);

}  // namespace nlo::trainer
