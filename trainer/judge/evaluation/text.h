// SPDX-License-Identifier: MIT
// Numbers, figures with their standard errors, and tables for readers. All rounding for readers happens here.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// Returns `digits` significant digits with trailing zeros: 0.18417 -> "0.184" (3). Plain notation from 1e-4 up to 1e6.
/// NaN is "-".
std::string significant(double value, int digits = 3);

/// Returns the number as above; "-" if there is no value.
std::string significant(const std::optional<double>& value, int digits = 3);

/// Returns a number with `decimals` digits after the point.
std::string fixed(double value, int decimals);

/// Returns "rate [rad/s]"; for a quantity without a unit its name.
std::string with_unit(const std::string& name, const std::string& unit);

/// Returns 0.0523 as "5.23 %". A share just below 1 gets one digit more, so that it is not rounded to 1.
std::string percent(double share);

/// A mean with its standard errors.
struct Spread {
  double mean = 0.0;
  /// Standard error over test sets (mean over the models on each); empty for one test set.
  std::optional<double> test_set_error = {};
  /// Standard error over models (mean over the test sets for each); empty for one model.
  std::optional<double> training_seed_error = {};
};

/// Returns "0.0952 ± 0.00040", as in the tables of results in docs/. The mean has three digits and the errors have one
/// decimal place more. Errors that are zero to this place are left out.
std::string to_text(const Spread& spread);

/// Returns the standard deviation of independent draws, or the standard error of their mean; nothing for fewer than
/// two.
std::optional<double> deviation_of(std::span<const double> draws);
std::optional<double> standard_error(std::span<const double> draws);

/// Returns the terminal columns of a UTF-8 text: one per code point, none for combining marks and control characters.
std::size_t display_width(std::string_view utf8);

/// Headings and rows. The first column is text (left), the others are numbers (right). An empty row is a thin line. A
/// row of one cell is the heading of the rows below it. On a page: html_table().
struct Table {
  std::vector<std::string> headings;
  std::vector<std::vector<std::string>> rows = {};  ///< missing cells are left blank

  void add_row(std::vector<std::string> cells) { rows.push_back(std::move(cells)); }
  void add_rule() { rows.emplace_back(); }

  /// Writes the table for a terminal: one line per row, each with a newline, indented by `indent` blanks. Columns that
  /// do not fit into `width` follow below, again beside the first column.
  std::string to_text(std::size_t indent = 0, std::size_t width = 100) const;

 private:
  std::string part(std::size_t indent, const std::vector<std::size_t>& widths, std::size_t from, std::size_t to) const;
};

}  // namespace nlo::trainer
