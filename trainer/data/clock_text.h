// SPDX-License-Identifier: MIT
// Stamps as people write them: 2026-11-20T10:11:12.345Z (ISO 8601), 2026-11-20 10:11:12.345, 10:11:12.345.
#pragma once

#include <optional>
#include <string_view>

namespace nlo::trainer {

/// A time of day, and its date where one is written.
struct ClockText {
  bool has_date = false;
  long day = 0;          ///< since 1970-01-01
  double seconds = 0.0;  ///< since midnight, in UTC if the text names its zone; above 86400 in a count of hours
};

/// Reads [YYYY-MM-DD(T| )]h:mm:ss[.fraction][Z|+hh:mm]. Also read: slashes in the date, a decimal comma, a date without
/// seconds. Empty where the text is anything else: 10:11 alone may be minutes.
std::optional<ClockText> read_clock_text(std::string_view text);

}  // namespace nlo::trainer
