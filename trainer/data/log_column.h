// SPDX-License-Identifier: MIT
// One column of a log as an experiment lists it: its heading, and the factor of its cells.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// One entry of [[log.columns]] and where its numbers come from.
struct LogColumn {
  std::string name, heading, unit;
  double wrap = 0.0;        ///< full turn of the values of `heading`; 0: not an angle
  bool derivative = false;  ///< the zero-phase velocity of those values, times `rate`
  bool sincos = false;      ///< two channels, NAME_sin and NAME_cos
  double delay_s = 0.0;     ///< an input acts this much later
  double period_s = 0.0;    ///< period of an output that is slower than the rows; 0: measured in every row
  double scale = 1.0;       ///< value = scale * cell + offset
  double offset = 0.0;
  double rate = 1.0;  ///< for a derivative: its unit in units of the values per second

  std::vector<std::string> missing = {};  ///< cells that stand for no value

  int channels() const { return sincos ? 2 : 1; }
};

/// Throws KeyError of `column`, which is one of `all`, with the fix.
[[noreturn]] void fail_at(const ColumnConfig& column, const std::vector<ColumnConfig>& all, std::string_view what);

/// Heading of the column in the file.
std::string heading_of(const ColumnConfig& column);

/// `column`, one of `all`, which has no expression. Throws KeyError as resolve_columns().
LogColumn resolve_column(const ColumnConfig& column, const std::vector<ColumnConfig>& all);

}  // namespace nlo::trainer
