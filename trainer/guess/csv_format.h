// SPDX-License-Identifier: MIT
// How a log separates its cells and its decimals, from its first lines.
#pragma once

#include <string_view>

#include "trainer/data/csv.h"

namespace nlo::trainer {

/// The first of ; tab , and blank that makes as many cells, two at least, of the first lines that are no comments; what
/// the reader takes by itself where none does. A decimal comma where the cells of numbers have one, and no point.
CsvFormat guess_csv_format(std::string_view text);

}  // namespace nlo::trainer
