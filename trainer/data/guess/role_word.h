// SPDX-License-Identifier: MIT
// Finds roles from the words and units of headings: a clock, a command, a sensor, a truth.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/choices.h"
#include "trainer/data/guess/heading.h"

namespace nlo::trainer {

/// Returns true for "time", "t", "header.stamp", "elapsed" ...
bool is_time_word(const Heading& heading);

/// Returns true for "stamp.sec" if `all` has a "stamp.nanosec", or the other way round: one time in two columns,
/// neither of which is a clock.
bool is_half_stamp(const Heading& heading, const std::vector<Heading>& all);

struct RoleWord {
  /// kIgnored: no word shows a role, or (`is_aside`) the name shows that the observer does not need the column ("y"
  /// beside "y_measured", a set point beside a command).
  ColumnRole role = ColumnRole::kIgnored;
  bool is_aside = false;
  std::string why;  ///< reason; empty: no word shows a role
};

/// Returns the role of `heading` among `all` headings of a log. Only whole words count, with or without a number at the
/// end ("pwm2"), and pairs of neighbouring words ("set_point").
RoleWord role_word(const Heading& heading, const std::vector<Heading>& all);

/// Returns the reason why a column is probably a sensor and not the truth: its quantity, such as a current, a
/// temperature or an acceleration. Empty: no reason.
std::string sensed_quantity(const Heading& heading);

}  // namespace nlo::trainer
