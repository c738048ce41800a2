// SPDX-License-Identifier: MIT
// Time stamps for readers: 2026-11-20T10:11:12.345Z (ISO 8601), 2026-11-20 10:11:12.345, 10:11:12.345.
#pragma once

#include <optional>
#include <string_view>

namespace nlo::trainer {

/// A time of day, and its date if there is one.
struct ClockText {
  bool has_date = false;
  long day = 0;          ///< since 1970-01-01
  double seconds = 0.0;  ///< since midnight, in UTC if the text has a time zone; above 86400 if hours count beyond 24
};

/// Reads [YYYY-MM-DD(T| )]h:mm:ss[.fraction][Z|+hh:mm]. Also reads slashes in the date, a decimal comma, and a date
/// without seconds. Returns nothing for any other text. "10:11" alone is not accepted, because it may mean minutes and
/// seconds.
std::optional<ClockText> read_clock_text(std::string_view text);

}  // namespace nlo::trainer
