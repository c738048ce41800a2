// SPDX-License-Identifier: MIT
// One column of a log in an experiment: its heading, and the conversion of its cells.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// One entry of [[log.columns]] and the source of its numbers.
struct LogColumn {
  std::string name, heading, unit;
  double wrap = 0.0;        ///< full turn of the values of `heading`; 0: not an angle
  bool derivative = false;  ///< true: the zero-phase velocity of these values, times `rate`
  bool sincos = false;      ///< true: two channels, NAME_sin and NAME_cos
  double delay_s = 0.0;     ///< delay of an input [s]: the input acts this much later than logged
  double period_s = 0.0;    ///< period of an output that is slower than the rows; 0: measured in every row
  double scale = 1.0;       ///< value = scale * cell + offset
  double offset = 0.0;
  double rate = 1.0;  ///< for a derivative: factor from values per second to its unit

  std::vector<std::string> missing = {};  ///< cells that mean no value

  int channels() const { return sincos ? 2 : 1; }
};

/// Throws KeyError for `column`, which is one of `all`, with the fix.
[[noreturn]] void fail_at(const ColumnConfig& column, const std::vector<ColumnConfig>& all, std::string_view what);

/// Returns the heading of the column in the file.
std::string heading_of(const ColumnConfig& column);

/// Resolves `column`, which is one of `all` and has no expression. Throws KeyError like resolve_columns().
LogColumn resolve_column(const ColumnConfig& column, const std::vector<ColumnConfig>& all);

}  // namespace nlo::trainer
