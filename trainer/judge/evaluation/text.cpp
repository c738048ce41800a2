// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

namespace nlo::trainer {
namespace {

constexpr std::size_t kInset = 2;  // indent of rows below the heading of a group

template <typename... Format>
std::string format(double value, Format... how) {
  std::array<char, 512> buffer;  // the longest double in fixed notation has 309 digits and its decimals
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, how...);
  return end.ec == std::errc() ? std::string(buffer.data(), end.ptr) : "?";
}

std::optional<double> variance_of(std::span<const double> draws) {
  if (draws.size() < 2) return std::nullopt;
  const auto n = static_cast<double>(draws.size());
  const double mean = std::accumulate(draws.begin(), draws.end(), 0.0) / n;
  double squares = 0.0;
  for (const double value : draws) squares += (value - mean) * (value - mean);
  return squares / (n - 1.0);
}

}  // namespace

std::string fixed(double value, int decimals) {
  return format(value, std::chars_format::fixed, decimals);
}

std::string significant(double value, int digits) {
  if (value == 0.0) return "0";
  if (std::isnan(value)) return "-";
  if (!std::isfinite(value)) return format(value);
  const std::string scientific = format(value, std::chars_format::scientific, digits - 1);
  // The exponent is read after rounding: 0.9996 with three digits is 1.00, not 0.1000.
  const auto mark = scientific.find('e');
  int exponent = 0;
  const char* first = scientific.data() + mark + 1;
  std::from_chars(*first == '+' ? first + 1 : first, scientific.data() + scientific.size(), exponent);
  if (exponent < -4 || exponent >= 6) return scientific;
  return fixed(value, std::max(0, digits - 1 - exponent));
}

std::string significant(const std::optional<double>& value, int digits) {
  return value ? significant(*value, digits) : "-";
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + "]";
}

std::string percent(double share) {
  return (share == 1.0 ? "100" : significant(100.0 * share, share > 0.99 ? 4 : 3)) + " %";
}

std::string to_text(const Spread& spread) {
  const std::string mean = significant(spread.mean);
  const std::size_t point = mean.find('.');
  const int places = 1 + (point == std::string::npos ? 0 : static_cast<int>(mean.size() - point - 1));
  const double least = 0.5 * std::pow(10.0, -places);
  const bool scientific = mean.find('e') != std::string::npos;
  if (scientific ? !spread.test_set_error && !spread.training_seed_error
                 : spread.test_set_error.value_or(0.0) < least && spread.training_seed_error.value_or(0.0) < least)
    return mean;
  std::string text = mean;
  for (const auto& error : {spread.test_set_error, spread.training_seed_error})
    if (error) text += " ± " + (scientific ? significant(*error, 2) : fixed(*error, places));
  return text;
}

std::optional<double> deviation_of(std::span<const double> draws) {
  const auto variance = variance_of(draws);
  return variance ? std::optional(std::sqrt(*variance)) : std::nullopt;
}

std::optional<double> standard_error(std::span<const double> draws) {
  const auto variance = variance_of(draws);
  return variance ? std::optional(std::sqrt(*variance / static_cast<double>(draws.size()))) : std::nullopt;
}

std::size_t display_width(std::string_view utf8) {
  std::size_t width = 0;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    if ((byte & 0xc0) == 0x80 || byte < 0x20 || byte == 0x7f) continue;  // continuation or control
    const bool combining = (byte == 0xcc || byte == 0xcd) && i + 1 < utf8.size() &&
                           (byte == 0xcc || static_cast<unsigned char>(utf8[i + 1]) < 0xb0);  // U+0300 to U+036F
    if (!combining) ++width;
  }
  return width;
}

std::string Table::to_text(std::size_t indent, std::size_t width) const {
  std::vector<std::size_t> widths;
  const auto measure = [&](const std::vector<std::string>& row, std::size_t inset) {
    if (row.size() > widths.size()) widths.resize(row.size());
    for (std::size_t i = row.size() == 1 ? 1 : 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], display_width(row[i]) + (i == 0 ? inset : 0));
  };
  measure(headings, 0);
  const bool grouped = std::ranges::any_of(rows, [](const auto& row) { return row.size() == 1; });
  for (const auto& row : rows) measure(row, grouped ? kInset : 0);

  std::string text;
  for (std::size_t from = 1, to = 0; to < widths.size(); from = to) {
    std::size_t total = indent + (widths.empty() ? 0 : widths[0]);
    for (to = from; to < widths.size() && (to == from || total + 2 + widths[to] <= width); ++to)
      total += 2 + widths[to];
    text += (text.empty() ? "" : "\n") + part(indent, widths, from, to);
  }
  return text;
}

/// Returns the first column, and the columns in [from, to).
std::string Table::part(std::size_t indent, const std::vector<std::size_t>& widths, std::size_t from,
                        std::size_t to) const {
  std::string text;
  const auto line = [&](std::vector<std::string> row, std::size_t inset) {
    std::string out(indent, ' ');
    if (!row.empty()) row[0].insert(0, inset, ' ');
    const auto cell = [&](std::size_t i) {
      const std::string content = i < row.size() ? row[i] : "";
      const std::string padding(widths[i] - display_width(content), ' ');
      out += i == 0 ? content + padding : "  " + padding + content;
    };
    if (!widths.empty()) cell(0);
    for (std::size_t i = from; i < to; ++i) cell(i);
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + '\n';
  };
  std::size_t total = widths.empty() ? 0 : widths[0];
  for (std::size_t i = from; i < to; ++i) total += 2 + widths[i];
  const auto rule = [&] {
    text += std::string(indent, ' ');
    for (std::size_t i = 0; i < total; ++i) text += "─";
    text += '\n';
  };
  line(headings, 0);
  std::size_t inset = 0;
  rule();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].empty() || (rows[r].size() == 1 && r > 0)) rule();
    if (rows[r].size() == 1) {
      text += std::string(indent, ' ') + rows[r][0] + '\n';
      inset = kInset;
    } else if (!rows[r].empty()) {
      line(rows[r], inset);
    }
  }
  return text;
}

}  // namespace nlo::trainer
