// SPDX-License-Identifier: MIT
#include "trainer/data/csv_format.h"

#include <algorithm>
#include <vector>

namespace nlo::trainer {
namespace {

/// Returns the cells of a line; separators within quotes do not count. ' ': any number of blanks is one separator.
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
  constexpr std::size_t kEnough = 64;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::string_view> lines;
  while (!text.empty() && lines.size() < kEnough) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t") != std::string_view::npos && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

/// Returns how many lines at the end have as many cells as the last line; 0 if the last line has one cell.
std::size_t table_lines(const std::vector<std::string_view>& lines, char separator) {
  if (lines.empty()) return 0;
  const std::size_t cells = cells_of(lines.back(), separator).size();
  if (cells < 2) return 0;
  const auto other = std::find_if(lines.rbegin(), lines.rend(),
                                  [&](std::string_view line) { return cells_of(line, separator).size() != cells; });
  return static_cast<std::size_t>(other - lines.rbegin());
}

/// Returns true for cells such as "-1,5" and "3,2e-4": digits on both sides of one comma.
bool has_decimal_comma(std::string_view cell) {
  const auto comma = cell.find(',');
  if (comma == std::string_view::npos || comma == 0 || comma + 1 == cell.size()) return false;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return is_digit(cell[comma - 1]) && is_digit(cell[comma + 1]) && cell.find('.') == std::string_view::npos &&
         cell.find(',', comma + 1) == std::string_view::npos;
}

/// Returns the decimal mark of the table in the last `count` lines, without its header. Returns `otherwise` if its
/// cells do not show the mark.
char decimal_in(const std::vector<std::string_view>& lines, std::size_t count, char separator, char otherwise) {
  bool comma = false, point = false;
  for (std::size_t i = lines.size() - count + 1; i < lines.size(); ++i)
    for (const std::string_view cell : cells_of(lines[i], separator)) {
      if (cell.find(':') != std::string_view::npos) continue;  // a time of day
      comma = comma || has_decimal_comma(cell);
      point = point || cell.find('.') != std::string_view::npos;
    }
  return separator == ',' || (comma && point) || (!comma && !point) ? otherwise : comma ? ',' : '.';
}

}  // namespace

CsvFormat guess_csv_format(std::string_view text) {
  const std::vector<std::string_view> lines = first_lines(text);
  CsvFormat format;
  std::size_t longest = 1;
  for (const char separator : {';', '\t', ',', ' '})
    if (const std::size_t count = table_lines(lines, separator); count > longest)
      longest = count, format.separator = separator;
  if (longest > 1) format.decimal = decimal_in(lines, longest, format.separator, '.');
  return format;
}

CsvFormat format_in(std::string_view text, const CsvFormat& told) {
  const std::vector<std::string_view> lines = first_lines(text);
  CsvFormat format = guess_csv_format(text);
  const std::size_t count = table_lines(lines, told.separator);
  if (table_lines(lines, format.separator) > count) return format;
  format = told;
  if (count > 1) format.decimal = decimal_in(lines, count, told.separator, told.decimal);
  return format;
}

}  // namespace nlo::trainer
