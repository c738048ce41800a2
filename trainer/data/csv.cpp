// SPDX-License-Identifier: MIT
#include "trainer/data/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"
#include "trainer/data/csv_beginning.h"
#include "trainer/data/csv_format.h"
#include "trainer/data/csv_records.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

/// Makes a cell printable. If a user gives a binary file as a log, its bytes must not reach the terminal.
std::string shown(std::string_view cell) {
  constexpr std::size_t kLongest = 40;
  return ascii(cell.substr(0, kLongest)) + (cell.size() > kLongest ? "..." : "");
}

std::vector<std::string> shown(const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& name : names) result.push_back(shown(name));
  return result;
}

/// Returns true if the cell has no value: it is empty, a dash, or a word for a missing value in any case.
bool is_missing(std::string_view cell) {
  constexpr auto kWords = std::to_array<std::string_view>(
      {"", "-", "--", "na", "n/a", "#n/a", "null", "none", "nil", "1.#qnan", "1.#snan", "1.#ind"});
  std::string word(trimmed(cell.substr(0, 40)));
  for (char& c : word) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c);
  const auto is_word = [&](std::string_view text) {
    return std::find(kWords.begin(), kWords.end(), text) != kWords.end();
  };
  if (is_word(word)) return true;
  std::string_view rest = word;  // some versions of printf write -nan or nan(ind)
  if (rest[0] == '-' || rest[0] == '+') rest.remove_prefix(1);
  return is_word(rest) || (rest.starts_with("nan") && (rest.size() == 3 || rest[3] == '('));
}

void check_headings(const std::vector<std::string>& headings, const std::string& file, int line, char separator,
                    std::string_view comment) {
  if (headings.size() == 1)
    for (const char other : {';', '\t', ','})
      if (other != separator && headings[0].find(other) != std::string::npos)
        throw Error(
            fmt::format("{}:{}: the columns seem to be separated by {}s: set separator = \"{}\" in [log], or write "
                        "the log with {}s",
                        file, line, in_words(other).substr(2), other == '\t' ? "tab" : std::string(1, other),
                        in_words(separator).substr(2)));
  double number = 0.0;
  if (std::all_of(headings.begin(), headings.end(),
                  [&](const std::string& heading) { return !read_number(heading, '.', number); }))
    throw Error(fmt::format(
        "{}:{}: the line has numbers, but the headings of the columns are expected here: {}", file, line,
        comment.empty() ? std::string("write a header row above them")
                        : fmt::format("is \"{}\" above them the header row? delete its #", shown(comment))));
}

[[noreturn]] void fail_ragged(const std::string& file, int line, std::size_t expected, std::size_t found, bool last,
                              bool blank) {
  const char* fix = blank  ? "the line is blank"
                    : last ? "the log ends inside a row: delete this last row"
                           : "correct or delete the row";
  throw Error(fmt::format("{}:{}: expected {} cells as in the header, found {}: {}", file, line, expected, found, fix));
}

void refuse_utf16(std::string_view text, const std::string& file) {
  if (!text.starts_with("\xFF\xFE") && !text.starts_with("\xFE\xFF")) return;
  throw Error(
      fmt::format("{}: the file is UTF-16 (by its byte order mark), but UTF-8 is expected: convert it with iconv -f "
                  "UTF-16 -t UTF-8 {} > utf8.csv",
                  file, file));
}

/// Refuses MAT-files, bags of ROS and compressed files, which are not text.
void refuse_recording(std::string_view text, const std::string& file) {
  using namespace std::string_view_literals;
  constexpr const char* kConvert = "python3 -m nlo.convert writes it as CSV (bindings/python/README.md)";
  constexpr const char* kConvertTwice =
      "ros2 bag convert writes it as SQLite, and python3 -m nlo.convert this as CSV (bindings/python/README.md)";
  struct Kind {
    std::string_view first_bytes;
    const char *name, *fix;
  };
  constexpr Kind kKinds[] = {{"MATLAB 5.0 MAT-file", "a MAT-file", kConvert},
                             {"MATLAB 7.3 MAT-file", "a MAT-file", kConvert},
                             {"SQLite format 3\0"sv, "an SQLite file (a bag of ROS 2?)", kConvert},
                             {"\x89MCAP0\r\n", "an MCAP file", kConvertTwice},
                             {"\x1f\x8b", "compressed by gzip", "gunzip writes the text"},
                             {"\x28\xB5\x2F\xFD", "compressed by zstd", "unzstd writes the text"},
                             {"\xFD"
                              "7zXZ",
                              "compressed by xz", "unxz writes the text"},
                             {"PK\x03\x04", "a zip archive or a spreadsheet", "unpack it, or save it as CSV"}};
  for (const Kind& kind : kKinds)
    if (text.starts_with(kind.first_bytes)) throw Error(fmt::format("{}: is {}: {}", file, kind.name, kind.fix));
}

}  // namespace

std::optional<const char*> read_number(std::string_view cell, char decimal, double& value) {
  cell = trimmed(cell);
  if (cell.empty()) return "is empty";
  std::string with_point;
  if (decimal == ',') {
    if (cell.find('.') != std::string_view::npos)
      return "has a point, but [log] decimal = \",\" declares a comma as the decimal mark";
    with_point = cell;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    cell = with_point;
  }
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (status == std::errc::result_out_of_range) return "is beyond the range of double";
  if (status != std::errc() || end != cell.data() + cell.size()) return "is not a number";
  if (!std::isfinite(value)) return "is not finite";
  return std::nullopt;
}

CsvTable CsvTable::read(const std::string& path, const CsvFormat& format) {
  std::string text = codegen::read_file(path);
  const CsvFormat own = format_in(text, format);
  return parse(std::move(text), path, own);
}

CsvTable CsvTable::parse(std::string text, std::string file, const CsvFormat& format) {
  CsvTable table;
  table.file_ = std::move(file);
  table.format_ = format;
  // Converts the line ends of old Macs.
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  table.text_ = std::make_shared<const std::string>(std::move(text));
  refuse_utf16(*table.text_, table.file_);
  refuse_recording(*table.text_, table.file_);

  CsvRecords records(*table.text_, table.file_, format.separator);
  if (records.rest_is_blank())
    throw Error(fmt::format("{}: the file is empty: expected a header row and rows of numbers", table.file_));
  const CsvBeginning beginning = find_beginning(records, format.decimal);
  std::vector<std::string_view> header;
  const auto skip = [&](std::size_t count) {
    for (; count > 0; --count) records.next(header);
    header.clear();
  };
  skip(beginning.header);
  const std::string_view comment = records.last_comment();
  table.header_line_ = records.line();
  records.next(header);
  table.headings_.assign(header.begin(), header.end());
  table.units_.assign(beginning.units.begin(), beginning.units.end());
  check_headings(table.headings_, table.file_, table.header_line_, format.separator, comment);
  if (records.rest_is_blank())
    throw Error(
        fmt::format("{}: there is a header but no data: expected rows of numbers below the header", table.file_));

  skip(beginning.skipped);
  const std::size_t columns = table.headings_.size();
  const auto lines = std::count(table.text_->begin(), table.text_->end(), '\n');
  table.lines_.reserve(static_cast<std::size_t>(lines));
  table.cells_.reserve(static_cast<std::size_t>(lines) * columns);
  std::vector<std::string_view> row;
  while (!records.at_end()) {
    const int line = records.line();
    row.clear();
    records.next(row);
    if (row.size() == columns && (columns > 1 || !row.back().empty())) {
      // A logger that is started again writes its headings again.
      if (std::ranges::equal(row, table.headings_)) continue;
      for (const std::string_view cell : row) table.cells_.push_back(table.place_in_text(cell, line));
      table.lines_.push_back(line);
      continue;
    }
    const bool blank = row.size() == 1 && row.back().empty();
    const bool last = records.rest_is_blank();
    if (!blank || !last) fail_ragged(table.file_, line, columns, blank ? 0 : row.size(), last, blank);
    break;
  }
  return table;
}

CsvTable::Place CsvTable::place_in_text(std::string_view cell, int line) const {
  constexpr std::size_t kLongest = (std::size_t{1} << 24) - 1;
  if (cell.size() > kLongest)
    throw Error(fmt::format("{}:{}: a cell has {} characters: is a closing quote missing?", file_, line, cell.size()));
  return {static_cast<std::uint64_t>(cell.data() - text_->data()) & ((std::uint64_t{1} << 40) - 1),
          static_cast<std::uint64_t>(cell.size()) & kLongest};
}

Eigen::VectorXd CsvTable::column(std::string_view heading) const {
  return read_column(heading, nullptr, {});
}

Eigen::VectorXd CsvTable::column(std::string_view heading, std::vector<Eigen::Index>& missing,
                                 const std::vector<std::string>& words) const {
  return read_column(heading, &missing, words);
}

std::vector<std::string_view> CsvTable::cells(std::string_view heading) const {
  std::vector<std::string_view> result;
  for (auto at = static_cast<std::size_t>(place_of(heading)); at < cells_.size(); at += headings_.size())
    result.push_back(text_at(cells_[at]));
  return result;
}

std::string_view CsvTable::cell(std::string_view heading, Eigen::Index row) const {
  return text_at(
      cells_[static_cast<std::size_t>(row) * headings_.size() + static_cast<std::size_t>(place_of(heading))]);
}

bool CsvTable::same_cells(Eigen::Index a, Eigen::Index b) const {
  const auto columns = static_cast<Eigen::Index>(headings_.size());
  const auto row = [&](Eigen::Index index) { return cells_.begin() + index * columns; };
  return std::equal(row(a), row(a + 1), row(b), [this](Place x, Place y) { return text_at(x) == text_at(y); });
}

std::string CsvTable::unit(std::string_view heading) const {
  if (units_.empty()) return "";
  return units_[static_cast<std::size_t>(std::find(headings_.begin(), headings_.end(), heading) - headings_.begin())];
}

bool CsvTable::is_ambiguous(std::string_view heading) const {
  return std::count(headings_.begin(), headings_.end(), heading) > 1;
}

Eigen::Index CsvTable::place_of(std::string_view heading) const {
  if (is_ambiguous(heading))
    throw Error(fmt::format("{}:{}: the heading \"{}\" occurs twice: rename one of the columns", file_, header_line_,
                            shown(heading)));
  const auto found = std::find(headings_.begin(), headings_.end(), heading);
  if (found == headings_.end()) {
    const std::string nearest = nearest_name(heading, headings_);
    std::string hint = nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", shown(nearest));
    if (headings_.size() == 1 && headings_[0].find(' ') != std::string::npos)
      hint = "; if spaces separate the columns, set separator = \"space\" in [log]";
    throw Error(fmt::format("{}:{}: no column \"{}\" among {}{}", file_, header_line_, shown(heading),
                            fmt::join(shown(headings_), ", "), hint));
  }
  return found - headings_.begin();
}

Eigen::VectorXd CsvTable::read_column(std::string_view heading, std::vector<Eigen::Index>* missing,
                                      const std::vector<std::string>& words) const {
  std::vector<double> numbers;
  for (const std::string& word : words)
    if (double number = 0.0; !read_number(word, '.', number)) numbers.push_back(number);
  const Eigen::Index offset = place_of(heading);
  const auto stride = static_cast<Eigen::Index>(headings_.size());
  Eigen::VectorXd values(rows());
  for (Eigen::Index row = 0; row < rows(); ++row) {
    const std::string_view cell = text_at(cells_[static_cast<std::size_t>(row * stride + offset)]);
    const auto wrong = read_number(cell, format_.decimal, values[row]);
    const bool is_listed = wrong ? std::ranges::find(words, trimmed(cell)) != words.end()
                                 : std::ranges::find(numbers, values[row]) != numbers.end();
    if (!wrong && !is_listed) continue;
    if (missing != nullptr && (is_listed || is_missing(cell))) {
      missing->push_back(row);
      values[row] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const bool comma = format_.decimal == '.' && std::count(cell.begin(), cell.end(), ',') == 1;
    throw Error(fmt::format(
        "{}:{}:{}: \"{}\" {}: {}", file_, line(row), shown(heading), shown(cell), *wrong,
        comma                ? "if a comma separates decimals, set decimal = \",\" in [log]"
        : missing != nullptr ? fmt::format("correct the row or delete it; if it marks a missing value, write missing = "
                                           "[\"{}\"] at the column",
                                           shown(cell))
                             : "correct the row or delete it"));
  }
  return values;
}

}  // namespace nlo::trainer
