// SPDX-License-Identifier: MIT
#include "trainer/data/csv_beginning.h"

#include <algorithm>
#include <cstddef>
#include <map>

#include "trainer/data/clock_text.h"
#include "trainer/data/csv.h"
#include "trainer/data/units.h"

namespace nlo::trainer {
namespace {

using Record = std::vector<std::string_view>;

bool is_blank(const Record& record) {
  return record.size() == 1 && record.front().empty();
}

std::vector<Record> first_records(CsvRecords& records) {
  constexpr std::size_t kEnough = 64;
  std::vector<Record> first;
  while (!records.at_end() && first.size() < kEnough) records.next(first.emplace_back());
  return first;
}

std::size_t usual_size(const std::vector<Record>& records) {
  std::map<std::size_t, std::size_t> count;
  for (const Record& record : records)
    if (!is_blank(record)) ++count[record.size()];
  std::size_t usual = 0, most = 0;
  for (const auto& [size, times] : count)
    if (times >= most) most = times, usual = size;
  return usual;
}

bool has_number(const Record& record, std::size_t column, char decimal) {
  double value = 0.0;
  return !read_number(record[column], decimal, value) || read_clock_text(record[column]);
}

bool has_numbers(const Record& record, char decimal) {
  for (std::size_t column = 0; column < record.size(); ++column)
    if (has_number(record, column, decimal)) return true;
  return false;
}

/// Returns true if record `at` and the next two records (or all records to the end) are rows of data: one column has a
/// number in each of them.
bool begins_rows(const std::vector<Record>& records, std::size_t at, std::size_t columns, char decimal) {
  constexpr std::size_t kRows = 3;
  std::size_t end = at;
  for (; end < records.size() && end < at + kRows; ++end) {
    const bool ends =
        end > at && std::all_of(records.begin() + static_cast<std::ptrdiff_t>(end), records.end(), is_blank);
    if (ends) break;
    if (records[end].size() != columns || is_blank(records[end])) return false;
  }
  for (std::size_t column = 0; column < columns; ++column) {
    std::size_t row = at;
    while (row < end && has_number(records[row], column, decimal)) ++row;
    if (row == end) return true;
  }
  return false;
}

std::string_view without_brackets(std::string_view unit) {
  unit = trimmed(unit);
  const bool is_within =
      unit.size() > 1 && ((unit.front() == '[' && unit.back() == ']') || (unit.front() == '(' && unit.back() == ')'));
  return is_within ? trimmed(unit.substr(1, unit.size() - 2)) : unit;
}

bool are_units(const Record& record) {
  std::size_t known = 0, given = 0;
  for (const std::string_view cell : record) {
    const std::string_view unit = without_brackets(cell);
    if (unit.empty() || unit == "-") continue;
    ++given;
    if (find_unit(unit) != nullptr) ++known;
  }
  return 2 * known > given;
}

}  // namespace

CsvBeginning find_beginning(CsvRecords records, char decimal) {
  const std::vector<Record> first = first_records(records);
  const std::size_t columns = usual_size(first);
  CsvBeginning begin;
  while (begin.header + 1 < first.size() && is_blank(first[begin.header])) ++begin.header;
  std::size_t rows = begin.header;
  while (rows < first.size() && !begins_rows(first, rows, columns, decimal)) ++rows;
  if (rows == first.size()) return begin;
  const auto is_words = [&](std::size_t at) {
    return first[at].size() == columns && !is_blank(first[at]) && !has_numbers(first[at], decimal);
  };
  const auto row_of_units = [&](std::size_t header) {
    return header + 2 <= rows && is_words(header + 1) && are_units(first[header + 1]);
  };
  // The header is a record of words. All records between it and the rows must have the right number of cells. The
  // topmost such record is the header; without one, the nearest record of words.
  std::size_t header = rows, nearest = rows;
  for (std::size_t at = rows; at-- > begin.header;) {
    if (!is_words(at)) continue;
    if (nearest == rows) nearest = at;
    std::size_t next = at + (row_of_units(at) ? 2 : 1);
    while (next < rows && is_blank(first[next])) ++next;
    const auto is_row = [&](const Record& record) { return record.size() == columns && !is_blank(record); };
    const auto from = first.begin() + static_cast<std::ptrdiff_t>(next),
               to = first.begin() + static_cast<std::ptrdiff_t>(rows);
    if (!is_words(next) && std::all_of(from, to, is_row)) header = at;
  }
  if (nearest == rows) {
    if (first[begin.header].size() != columns) begin.header = rows;  // no header: the reader reports it
    return begin;
  }
  begin.header = header < rows ? header : nearest;
  if (row_of_units(begin.header)) {
    begin.skipped = 1;
    for (const std::string_view cell : first[begin.header + 1]) {
      const std::string_view unit = without_brackets(cell);
      begin.units.push_back(unit == "-" ? std::string_view() : unit);
    }
  }
  while (begin.header + 1 + begin.skipped < rows && is_blank(first[begin.header + 1 + begin.skipped])) ++begin.skipped;
  return begin;
}

}  // namespace nlo::trainer
