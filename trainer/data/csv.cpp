// SPDX-License-Identifier: MIT
#include "trainer/data/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/nearest_name.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Where the cell ends that starts `text`: plain bytes, a third faster here than find_first_of.
std::size_t cell_end(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size() && text[end] != ',' && text[end] != '\n') ++end;
  return end;
}

/// What a terminal can show of a cell: a binary file taken for a log must not reach it unfiltered.
std::string shown(std::string_view cell) {
  constexpr std::size_t kLongest = 40;
  std::string text(cell.substr(0, kLongest));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, '?');
  return cell.size() > kLongest ? text + "..." : text;
}

std::vector<std::string> shown(const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& name : names) result.push_back(shown(name));
  return result;
}

/// Walks over the text one record (a line, unless a quoted cell spans several) at a time.
class Records {
 public:
  Records(std::string_view text, std::string_view file) : text_(text), file_(file) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  }

  bool at_end() const { return text_.empty(); }
  int line() const { return line_; }
  bool rest_is_blank() const { return text_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

  /// Appends the cells of the next record and returns how many they are.
  std::size_t next(std::vector<std::string_view>& cells) {
    std::size_t count = 0;
    for (bool more = true; more; ++count) more = next_cell(cells);
    return count;
  }

 private:
  /// Reads one cell and its separator; true when a comma follows.
  bool next_cell(std::vector<std::string_view>& cells) {
    const std::size_t first = text_.find_first_not_of(" \t");
    if (first != std::string_view::npos && text_[first] == '"') {
      text_.remove_prefix(first);
      return next_quoted(cells);
    }
    const std::size_t end = cell_end(text_);
    std::string_view cell = text_.substr(0, end);
    const bool more = end < text_.size() && text_[end] == ',';
    if (!more && cell.ends_with('\r')) cell.remove_suffix(1);
    cells.push_back(trimmed(cell));
    return step_over(end, more);
  }

  /// A doubled quote inside stays doubled: numbers have none, and a heading may be asked for as it stands in the file.
  bool next_quoted(std::vector<std::string_view>& cells) {
    const int opened = line_;
    std::size_t close = text_.find('"', 1);
    while (close != std::string_view::npos && close + 1 < text_.size() && text_[close + 1] == '"')
      close = text_.find('"', close + 2);
    if (close == std::string_view::npos)
      throw Error(fmt::format("{}:{}: a quote is opened and never closed", file_, opened));
    const std::string_view cell = text_.substr(1, close - 1);
    line_ += static_cast<int>(std::count(cell.begin(), cell.end(), '\n'));
    cells.push_back(cell);
    text_.remove_prefix(close + 1);

    const std::size_t end = cell_end(text_);
    if (text_.substr(0, end).find_first_not_of(" \t\r") != std::string_view::npos)
      throw Error(
          fmt::format("{}:{}: text follows a closing quote: expected a comma or the end of the line", file_, line_));
    return step_over(end, end < text_.size() && text_[end] == ',');
  }

  bool step_over(std::size_t end, bool more) {
    if (end < text_.size() && !more) ++line_;
    text_.remove_prefix(std::min(end + 1, text_.size()));
    return more;
  }

  std::string_view text_;
  std::string_view file_;
  int line_ = 1;
};

void check_headings(const std::vector<std::string>& headings, const std::string& file) {
  if (headings.size() == 1 && headings[0].find_first_of(";\t") != std::string::npos)
    throw Error(fmt::format("{}:1: the columns seem to be separated by {}: write the log with commas", file,
                            headings[0].find(';') != std::string::npos ? "semicolons" : "tabs"));
  std::vector<std::string> sorted = headings;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end(),
                                        [](const auto& a, const auto& b) { return !a.empty() && a == b; });
  if (twice != sorted.end())
    throw Error(fmt::format("{}:1: the heading \"{}\" occurs twice: rename one of the columns", file, shown(*twice)));
}

[[noreturn]] void fail_ragged(const std::string& file, int line, std::size_t expected, std::size_t found, bool last,
                              bool blank) {
  const char* remedy = blank  ? "the line is blank"
                       : last ? "the log ends inside a row: delete it"
                              : "correct or delete the row";
  throw Error(
      fmt::format("{}:{}: expected {} cells as in the header, found {}: {}", file, line, expected, found, remedy));
}

/// What keeps a cell from being a finite decimal number; nothing when `value` has been set.
std::optional<const char*> read_number(std::string_view cell, double& value) {
  cell = trimmed(cell);
  if (cell.empty()) return "is empty";
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (status == std::errc::result_out_of_range) return "is beyond the range of double";
  if (status != std::errc() || end != cell.data() + cell.size()) return "is not a number";
  if (!std::isfinite(value)) return "is not finite";
  return std::nullopt;
}

}  // namespace

CsvTable CsvTable::read(const std::string& path) {
  return parse(codegen::read_file(path), path);
}

CsvTable CsvTable::parse(std::string text, std::string file) {
  CsvTable table;
  table.file_ = std::move(file);
  table.text_ = std::make_shared<const std::string>(std::move(text));

  Records records(*table.text_, table.file_);
  if (records.rest_is_blank())
    throw Error(fmt::format("{}: the file is empty: expected a header row and rows of numbers", table.file_));
  std::vector<std::string_view> header;
  records.next(header);
  table.headings_.assign(header.begin(), header.end());
  check_headings(table.headings_, table.file_);
  if (records.rest_is_blank())
    throw Error(fmt::format("{}: a header and no data: expected rows of numbers below it", table.file_));

  const std::size_t columns = table.headings_.size();
  const auto lines = std::count(table.text_->begin(), table.text_->end(), '\n');
  table.lines_.reserve(static_cast<std::size_t>(lines));
  table.cells_.reserve(static_cast<std::size_t>(lines) * columns);
  while (!records.at_end()) {
    const int line = records.line();
    const std::size_t found = records.next(table.cells_);
    if (found == columns && (columns > 1 || !table.cells_.back().empty())) {
      table.lines_.push_back(line);
      continue;
    }
    const bool blank = found == 1 && table.cells_.back().empty();
    const bool last = records.rest_is_blank();
    if (!blank || !last) fail_ragged(table.file_, line, columns, blank ? 0 : found, last, blank);
    table.cells_.pop_back();
    break;
  }
  return table;
}

Eigen::VectorXd CsvTable::column(std::string_view heading) const {
  const auto found = std::find(headings_.begin(), headings_.end(), heading);
  if (found == headings_.end()) {
    const std::string nearest = nearest_name(heading, headings_);
    const std::string hint = nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", shown(nearest));
    throw Error(fmt::format("{}:1: no column \"{}\" among {}{}", file_, shown(heading),
                            fmt::join(shown(headings_), ", "), hint));
  }
  const auto offset = found - headings_.begin();
  const auto stride = static_cast<Eigen::Index>(headings_.size());
  Eigen::VectorXd values(rows());
  for (Eigen::Index row = 0; row < rows(); ++row) {
    const std::string_view cell = cells_[static_cast<std::size_t>(row * stride + offset)];
    if (const auto wrong = read_number(cell, values[row]))
      throw Error(fmt::format("{}:{}:{}: \"{}\" {}: correct the row or delete it", file_, line(row), shown(heading),
                              shown(cell), *wrong));
  }
  return values;
}

}  // namespace nlo::trainer
