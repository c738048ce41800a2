// SPDX-License-Identifier: MIT
// Numbers, figures with their standard errors, and tables as people read them: rounded here and nowhere else.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// `digits` significant digits, trailing zeros kept: 0.18417 -> "0.184" (3).
/// Plain notation from 1e-4 up to 1e6. NaN is "-".
std::string significant(double value, int digits = 3);

/// As significant(), "-" when there is no value.
std::string significant(const std::optional<double>& value, int digits = 3);

/// `decimals` digits after the point.
std::string fixed(double value, int decimals);

/// "rate [rad/s]"; of a quantity without a unit its name.
std::string with_unit(const std::string& name, const std::string& unit);

/// 0.0523 -> "5.23 %". A share just below 1 has a digit more, so that it is not rounded to 1.
std::string percent(double share);

/// A mean and the standard errors of it.
struct Spread {
  double mean = 0.0;
  /// Over test sets (mean over the models on each); empty for one test set.
  std::optional<double> test_set_error = {};
  /// Over models (mean over the test sets for each); empty for one model.
  std::optional<double> training_seed_error = {};
};

/// "0.0952 ± 0.00040": three digits, and the errors to one place more unless all of them round to zero there. As the
/// tables of results in docs/.
std::string to_text(const Spread& spread);

/// Standard deviation of independent draws, and standard error of their mean; empty for fewer than two.
std::optional<double> deviation_of(std::span<const double> draws);
std::optional<double> standard_error(std::span<const double> draws);

/// Terminal columns that UTF-8 text takes: one per code point, none for combining marks and control characters.
std::size_t display_width(std::string_view utf8);

/// Headings and rows; the first column is text (left), the others are numbers (right). An empty row is a thin line, a
/// row of one cell the heading of those below. On a page: html_table().
struct Table {
  std::vector<std::string> headings;
  std::vector<std::vector<std::string>> rows = {};  ///< missing cells are left blank

  void add_row(std::vector<std::string> cells) { rows.push_back(std::move(cells)); }
  void add_rule() { rows.emplace_back(); }

  /// For a terminal: one line per row, each ending in a newline, indented by `indent` blanks. Columns that would reach
  /// past `width` follow below, beside the first column once more.
  std::string to_text(std::size_t indent = 0, std::size_t width = 100) const;

 private:
  std::string part(std::size_t indent, const std::vector<std::size_t>& widths, std::size_t from, std::size_t to) const;
};

}  // namespace nlo::trainer
