// SPDX-License-Identifier: MIT
// Splits a text into records of cells before any cell is read (RFC 4180 quoting; LF or CRLF). Skips a byte order mark
// and lines that begin with #.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/trimmed.h"

namespace nlo::trainer {

inline std::string in_words(char separator) {
  switch (separator) {
    case ',':
      return "a comma";
    case ';':
      return "a semicolon";
    case '\t':
      return "a tab";
    default:
      return "a space";
  }
}

/// Reads the text one record at a time (a line, unless a quoted cell spans several lines).
class CsvRecords {
 public:
  CsvRecords(std::string_view text, std::string_view file, char separator)
      : text_(text), file_(file), separator_(separator) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
    skip_comments();
  }

  bool at_end() const { return text_.empty(); }
  int line() const { return line_; }
  std::string_view last_comment() const { return comment_; }
  bool rest_is_blank() const { return text_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

  /// Appends the cells of the next record and returns their number.
  std::size_t next(std::vector<std::string_view>& cells) {
    std::size_t count = 0;
    skip_spaces();
    for (bool more = true; more; ++count) more = next_cell(cells);
    skip_comments();
    return count;
  }

 private:
  /// Skips lines whose first character is #.
  void skip_comments() {
    while (true) {
      const std::size_t first = text_.find_first_not_of(" \t");
      if (first == std::string_view::npos || text_[first] != '#') return;
      const std::size_t end = text_.find('\n');
      comment_ = trimmed(text_.substr(0, end));
      if (comment_.ends_with('\r')) comment_.remove_suffix(1);
      if (end != std::string_view::npos) ++line_;
      text_.remove_prefix(std::min(end, text_.size() - 1) + 1);
    }
  }

  void skip_spaces() {
    if (separator_ == ' ') text_.remove_prefix(std::min(text_.find_first_not_of(" \t"), text_.size()));
  }

  bool is_separator(char c) const { return c == separator_ || (separator_ == ' ' && c == '\t'); }

  /// Returns the end of the cell that starts `text`. A loop over bytes is a third faster here than find_first_of.
  std::size_t cell_end(std::string_view text) const {
    std::size_t end = 0;
    if (separator_ != ' ')
      while (end < text.size() && text[end] != separator_ && text[end] != '\n') ++end;
    else
      while (end < text.size() && !is_separator(text[end]) && text[end] != '\n') ++end;
    return end;
  }

  /// Returns true if another cell of the record follows the one that ends at `end`.
  bool more_behind(std::size_t end) const {
    if (end >= text_.size() || !is_separator(text_[end])) return false;
    if (separator_ != ' ') return true;
    const std::size_t next = text_.find_first_not_of(" \t\r", end);
    return next != std::string_view::npos && text_[next] != '\n';
  }

  /// Reads one cell and its separator. Returns true if another cell follows.
  bool next_cell(std::vector<std::string_view>& cells) {
    const std::size_t first = text_.find_first_not_of(separator_ == '\t' ? " " : " \t");
    if (first != std::string_view::npos && text_[first] == '"') {
      text_.remove_prefix(first);
      return next_quoted(cells);
    }
    const std::size_t end = cell_end(text_);
    std::string_view cell = text_.substr(0, end);
    const bool more = more_behind(end);
    if (!more && cell.ends_with('\r')) cell.remove_suffix(1);
    cells.push_back(trimmed(cell));
    return step_over(end, more);
  }

  /// Reads a quoted cell. A doubled quote inside stays doubled: numbers have none, and a heading is looked up as it is
  /// in the file.
  bool next_quoted(std::vector<std::string_view>& cells) {
    const int opened = line_;
    std::size_t close = text_.find('"', 1);
    while (close != std::string_view::npos && close + 1 < text_.size() && text_[close + 1] == '"')
      close = text_.find('"', close + 2);
    if (close == std::string_view::npos)
      throw codegen::Error(fmt::format("{}:{}: a quote is opened and never closed", file_, opened));
    const std::string_view cell = text_.substr(1, close - 1);
    line_ += static_cast<int>(std::count(cell.begin(), cell.end(), '\n'));
    cells.push_back(cell);
    text_.remove_prefix(close + 1);

    const std::size_t end = cell_end(text_);
    if (text_.substr(0, end).find_first_not_of(" \t\r") != std::string_view::npos)
      throw codegen::Error(fmt::format("{}:{}: text follows a closing quote: expected {} or the end of the line", file_,
                                       line_, in_words(separator_)));
    return step_over(end, more_behind(end));
  }

  bool step_over(std::size_t end, bool more) {
    if (!more) end = std::min(text_.find('\n', end), text_.size());  // spaces may follow the last cell
    if (end < text_.size() && !more) ++line_;
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (more) skip_spaces();
    return more;
  }

  std::string_view text_;
  std::string_view file_;
  std::string_view comment_;
  char separator_;
  int line_ = 1;
};

}  // namespace nlo::trainer
