// SPDX-License-Identifier: MIT
// Roles that the words and units of headings tell: a clock, a command, a sensor, a truth.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/choices.h"
#include "trainer/data/guess/heading.h"

namespace nlo::trainer {

/// "time", "t", "header.stamp", "elapsed" ...
bool is_time_word(const Heading& heading);

/// "stamp.sec" where `all` has a "stamp.nanosec", or the other way round: one time in two columns, none of which is a
/// clock by itself.
bool is_half_stamp(const Heading& heading, const std::vector<Heading>& all);

struct RoleWord {
  /// kIgnored: no word tells, or `is_aside`: a name that says that the column is not for the observer ("y" beside
  /// "y_measured", a set point beside a command).
  ColumnRole role = ColumnRole::kIgnored;
  bool is_aside = false;
  std::string why;  ///< empty: nothing tells
};

/// The role of `heading` among `all` headings of a log. A word counts as a whole, with or without a number behind it
/// ("pwm2"), and so do two neighbours together ("set_point").
RoleWord role_word(const Heading& heading, const std::vector<Heading>& all);

/// Why a sensor is likelier than a truth that only a log has, by the quantity: a current, a temperature, an
/// acceleration. Empty: nothing tells.
std::string sensed_quantity(const Heading& heading);

}  // namespace nlo::trainer
