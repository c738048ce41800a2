// SPDX-License-Identifier: MIT
// How a log separates its cells and its decimals, from its first lines.
#pragma once

#include <string_view>

#include "trainer/data/csv.h"

namespace nlo::trainer {

/// The first of ; tab , and blank that makes as many cells, two at least, of the most of the first lines, counted back
/// from the last of them: a preamble stands above a table. Lines that are blank or comments do not count. The default
/// format where none does. A decimal comma where the cells of numbers have one, and no point.
CsvFormat guess_csv_format(std::string_view text);

/// `told`, unless the first lines make a longer table by another separator, or their decimals are others: one file of a
/// fleet may come from another spreadsheet.
CsvFormat format_in(std::string_view text, const CsvFormat& told);

}  // namespace nlo::trainer
