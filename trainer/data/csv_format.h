// SPDX-License-Identifier: MIT
// Finds the separator and the decimal mark of a log from its first lines.
#pragma once

#include <string_view>

#include "trainer/data/csv.h"

namespace nlo::trainer {

/// Returns the separator (; tab , or blank) with which the most lines have the same number of cells, at least two. The
/// first separator in this order wins a tie. Lines are counted back from the last of the first lines, because a
/// preamble is above a table. Blank lines and comments do not count. Returns the default format if there is no such
/// separator. The decimal mark is a comma if the cells of numbers have one and no point.
CsvFormat guess_csv_format(std::string_view text);

/// Returns `told`, unless the first lines show another format: a longer table with another separator, or another
/// decimal mark. One file of a fleet may come from another spreadsheet.
CsvFormat format_in(std::string_view text, const CsvFormat& told);

}  // namespace nlo::trainer
