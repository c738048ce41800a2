// SPDX-License-Identifier: MIT
// Numbers and tables as people read them: locale-proof formatting, and columns that line up on a terminal.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// `digits` significant digits, trailing zeros kept: 0.18417 -> "0.184" (3). Plain notation from 1e-4 up to 1e6.
std::string significant(double value, int digits = 3);

/// As significant(), "-" when there is no value.
std::string significant(const std::optional<double>& value, int digits = 3);

/// `decimals` digits after the point.
std::string fixed(double value, int decimals);

/// Terminal columns that UTF-8 text takes: one per code point, none for combining marks and control characters.
std::size_t display_width(std::string_view utf8);

/// Headings and rows; the first column is text (left), the others are numbers (right).
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> headings) : headings_(std::move(headings)) {}

  /// Missing cells are left blank.
  void add_row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  /// A thin line between groups of rows.
  void add_rule() { rows_.emplace_back(); }

  bool empty() const { return rows_.empty(); }

  /// One line per row, each ending in a newline, indented by `indent` blanks. Columns that would reach past `width`
  /// follow below, beside the first column once more.
  std::string to_string(std::size_t indent = 0, std::size_t width = kWidest) const;

 private:
  static constexpr std::size_t kWidest = 100;

  std::string part(std::size_t indent, const std::vector<std::size_t>& widths, std::size_t from, std::size_t to) const;

  std::vector<std::string> headings_;
  std::vector<std::vector<std::string>> rows_;  ///< an empty row is a rule
};

}  // namespace nlo::trainer
