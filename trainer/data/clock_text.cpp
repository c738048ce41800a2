// SPDX-License-Identifier: MIT
#include "trainer/data/clock_text.h"

#include <charconv>
#include <chrono>
#include <string>

#include "trainer/data/csv_records.h"

namespace nlo::trainer {
namespace {

/// Reads numbers and characters from the front of a text. `failed` is set when an expected one is missing.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  bool failed() const { return failed_; }
  bool at_end() const { return text_.empty(); }

  bool take(std::string_view marks) {
    if (text_.empty() || marks.find(text_.front()) == std::string_view::npos) return false;
    text_.remove_prefix(1);
    return true;
  }

  void expect(std::string_view marks) { failed_ = !take(marks) || failed_; }

  /// Reads an integer of `fewest` to `most` digits, at most `largest`.
  int number(std::size_t fewest, std::size_t most, int largest) {
    std::size_t digits = 0;
    while (digits < text_.size() && digits < most && is_digit(text_[digits])) ++digits;
    int value = 0;
    std::from_chars(text_.data(), text_.data() + digits, value);
    failed_ = failed_ || digits < fewest || value > largest;
    text_.remove_prefix(digits);
    return value;
  }

  /// Reads the digits after a decimal point.
  double fraction() {
    std::string digits = "0.";
    for (; !text_.empty() && is_digit(text_.front()); text_.remove_prefix(1)) digits += text_.front();
    failed_ = failed_ || digits.size() == 2;
    double value = 0.0;
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value;
  }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }

  std::string_view text_;
  bool failed_ = false;
};

}  // namespace

std::optional<ClockText> read_clock_text(std::string_view text) {
  text = trimmed(text);
  ClockText result;
  result.has_date = text.size() > 4 && (text[4] == '-' || text[4] == '/');
  Scanner scan(text);
  if (result.has_date) {
    const std::chrono::year year(scan.number(4, 4, 9999));
    scan.expect("-/");
    const auto month = static_cast<unsigned>(scan.number(1, 2, 12));
    scan.expect("-/");
    const auto day = static_cast<unsigned>(scan.number(1, 2, 31));
    scan.expect("Tt ");
    const std::chrono::year_month_day date(year, std::chrono::month(month), std::chrono::day(day));
    if (scan.failed() || !date.ok()) return std::nullopt;
    result.day = std::chrono::sys_days(date).time_since_epoch().count();
  }
  const int hours = result.has_date ? scan.number(1, 2, 24) : scan.number(1, 4, 9999);
  scan.expect(":");
  const int minutes = scan.number(2, 2, 59);
  double seconds = 0.0;
  if (scan.take(":")) {
    seconds = scan.number(2, 2, 60);
    if (scan.take(".,")) seconds += scan.fraction();
  } else if (!result.has_date) {
    return std::nullopt;
  }
  if (result.has_date) scan.take(" ");
  int zone_minutes = 0;
  if (const bool is_east = scan.take("+"); is_east || scan.take("-")) {
    const int zone_hours = scan.number(2, 2, 23);
    scan.take(":");
    zone_minutes = 60 * zone_hours + (scan.at_end() ? 0 : scan.number(2, 2, 59));
    if (!is_east) zone_minutes = -zone_minutes;
  } else {
    scan.take("Zz");
  }
  if (scan.failed() || !scan.at_end()) return std::nullopt;
  result.seconds = 60.0 * (60 * hours + minutes - zone_minutes) + seconds;
  return result;
}

}  // namespace nlo::trainer
