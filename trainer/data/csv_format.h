// SPDX-License-Identifier: MIT
// Finds the separator and the decimal mark of a log from its first lines.
#pragma once

#include <string_view>

#include "trainer/data/csv.h"

namespace nlo::trainer {

/// Returns the first of ; tab , and blank with which the most lines have equally many cells, at least two. Lines are
/// counted back from the last of the first lines, because a preamble is above a table. Blank lines and comments do not
/// count. Returns the default format if there is no such separator. The decimal mark is a comma if the cells of numbers
/// have one and no point.
CsvFormat guess_csv_format(std::string_view text);

/// Returns `told`, unless another separator makes a longer table of the first lines, or they have another decimal mark:
/// one file of a fleet may come from another spreadsheet.
CsvFormat format_in(std::string_view text, const CsvFormat& told);

}  // namespace nlo::trainer
