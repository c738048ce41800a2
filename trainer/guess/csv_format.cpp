// SPDX-License-Identifier: MIT
#include "trainer/guess/csv_format.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer {
namespace {

/// Cells of a line; separators within quotes do not count. ' ': any number of blanks separates.
std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  bool quoted = false;
  std::size_t from = 0;
  const auto is_separator = [&](char c) { return c == separator || (separator == ' ' && c == '\t'); };
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || !is_separator(line[i]))) continue;
    if (separator != ' ' || i > from) cells.push_back(line.substr(from, i - from));
    from = i + 1;
  }
  return cells;
}

std::vector<std::string_view> first_lines(std::string_view text) {
  constexpr std::size_t kEnough = 20;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::string_view> lines;
  while (!text.empty() && lines.size() < kEnough) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

/// "-1,5", "3,2e-4": digits on both sides of one comma.
bool has_decimal_comma(std::string_view cell) {
  const auto comma = cell.find(',');
  if (comma == std::string_view::npos || comma == 0 || comma + 1 == cell.size()) return false;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return is_digit(cell[comma - 1]) && is_digit(cell[comma + 1]) && cell.find('.') == std::string_view::npos &&
         cell.find(',', comma + 1) == std::string_view::npos;
}

}  // namespace

CsvFormat guess_csv_format(std::string_view text) {
  const std::vector<std::string_view> lines = first_lines(text);
  CsvFormat format;
  if (lines.size() < 2) return format;
  const auto separates = [&](char separator) {
    const std::size_t cells = cells_of(lines.front(), separator).size();
    return cells > 1 &&
           std::ranges::all_of(lines, [&](std::string_view line) { return cells_of(line, separator).size() == cells; });
  };
  constexpr std::string_view kSeparators = ";\t, ";
  const auto found = std::ranges::find_if(kSeparators, separates);
  if (found == kSeparators.end()) return format;
  format.separator = *found;
  if (format.separator == ',') return format;
  bool comma = false, point = false;
  for (std::size_t i = 1; i < lines.size(); ++i)
    for (const std::string_view cell : cells_of(lines[i], format.separator)) {
      comma = comma || has_decimal_comma(cell);
      point = point || cell.find('.') != std::string_view::npos;
    }
  if (comma && !point) format.decimal = ',';
  return format;
}

}  // namespace nlo::trainer
