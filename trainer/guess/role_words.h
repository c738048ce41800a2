// SPDX-License-Identifier: MIT
// What words in headings say of a column: a clock, a command, a sensor, a truth.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/choices.h"
#include "trainer/guess/column_numbers.h"
#include "trainer/guess/heading.h"

namespace nlo::trainer {

/// "time", "t", "stamp", "elapsed" ...
bool is_time_word(const Heading& heading);

/// What a stamp counts: its heading's unit, or what its steps look like (a log has from 1 to 10,000 rows a second;
/// whole numbers are finer units).
struct TimeUnit {
  std::string name;
  double seconds = 1.0;
  std::string why;
};
TimeUnit time_unit(const Heading& heading, const ColumnNumbers& stamps);

/// kIgnored: no word tells, or `is_aside`: a name that says that the column is not for the observer ("y" beside
/// "y_measured", a set point).
struct RoleWord {
  ColumnRole role = ColumnRole::kIgnored;
  bool is_aside = false;
  std::string why;  ///< empty: nothing tells
};
RoleWord role_word(const Heading& heading, const std::vector<std::string>& all_headings);

/// A length or an angle, whose derivative is a velocity.
bool is_position(const std::string& unit);

}  // namespace nlo::trainer
