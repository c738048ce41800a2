// SPDX-License-Identifier: MIT
#include "trainer/data/guess/column_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/error.h"
#include "trainer/data/csv_records.h"
#include "trainer/data/empty_cells.h"
#include "trainer/data/impossible_values.h"
#include "trainer/data/log_stamps.h"
#include "trainer/data/time_stamps.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Returns the cell in a message of CsvTable: FILE:LINE:HEADING: "CELL" is no number.
std::string cell_in(const std::string& message) {
  const auto end = message.find("\" is ");
  const auto from = end == std::string::npos || end == 0 ? std::string::npos : message.rfind('"', end - 1);
  return from == std::string::npos ? "" : message.substr(from + 1, end - from - 1);
}

/// Cells of a column that are not numbers.
struct CellWords {
  std::vector<std::string> cells;  ///< each cell once
  bool are_few = true;             ///< at most three different cells, in less than half of the rows
  std::string where;               ///< place of the first such cell and their number; empty: there are none
};

CellWords words_in(const std::vector<CsvTable>& tables, const std::string& heading) {
  constexpr std::size_t kMost = 3;
  CellWords words;
  for (std::size_t i = 0; i < tables.size();) {
    try {
      std::vector<Index> missing;
      tables[i].column(heading, missing, words.cells);
      ++i;
    } catch (const codegen::Error& error) {
      words.cells.push_back(cell_in(error.what()));
      words.are_few = words.cells.size() <= kMost;
      if (!words.are_few) return words;
    }
  }
  if (words.cells.empty()) return words;
  Index rows = 0, found = 0;
  for (const CsvTable& table : tables) {
    rows += table.rows();
    const std::vector<std::string_view> cells = table.cells(heading);
    for (std::size_t row = 0; row < cells.size(); ++row) {
      if (std::ranges::find(words.cells, trimmed(cells[row])) == words.cells.end()) continue;
      if (found++ == 0)
        words.where = fmt::format("{}:{}: \"{}\" is \"{}\" here", table.file(), table.line(static_cast<Index>(row)),
                                  heading, cells[row]);
    }
  }
  words.are_few = found > 0 && 2 * found < rows;
  words.where +=
      fmt::format(" and in {:.2g} % of its rows", 100.0 * static_cast<double>(found) / static_cast<double>(rows));
  return words;
}

VectorXd steps_of(const VectorXd& values) {
  return values.tail(values.size() - 1) - values.head(values.size() - 1);
}

}  // namespace

ColumnNumbers ColumnNumbers::of(const std::vector<CsvTable>& tables, const std::string& heading, bool is_command) {
  ColumnNumbers numbers;
  const CellWords words = words_in(tables, heading);
  if (!words.are_few) {
    numbers.is_numeric_ = numbers.increases_ = false;
    numbers.first_cell_ = words.cells.front();
    return numbers;
  }
  for (const CsvTable& table : tables) {
    std::vector<Index> missing;
    numbers.files_.push_back(table.column(heading, missing, words.cells));
    const VectorXd& values = numbers.files_.back();
    const Index spacing = regular_spacing(missing, table.rows());
    numbers.spacing_ = numbers.files_.size() == 1 || spacing == numbers.spacing_ ? spacing : 0;
    numbers.increases_ =
        numbers.increases_ && missing.empty() && values.size() > 1 && (steps_of(values).array() > 0.0).all();
  }
  const ImpossibleValues impossible =
      numbers.increases_ ? ImpossibleValues() : impossible_values(numbers.files_, is_command);
  numbers.missing_ = words.cells;
  numbers.where_missing_ = words.where;
  if (!impossible.values.empty()) {
    const CsvTable& table = tables[impossible.file];
    numbers.where_missing_ = to_text(impossible, heading, table.file(), table.line(impossible.row));
    const std::vector<std::string> cells = as_cells(impossible);
    numbers.missing_.insert(numbers.missing_.end(), cells.begin(), cells.end());
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (VectorXd& values : numbers.files_) {
    Index kept = 0;
    for (const double value : values)
      if (std::isfinite(value) && std::ranges::find(impossible.values, value) == impossible.values.end())
        values[kept++] = value;
    values.conservativeResize(kept);
    if (kept > 0) low = std::min(low, values.minCoeff()), high = std::max(high, values.maxCoeff());
  }
  numbers.is_numeric_ = low <= high;
  numbers.increases_ = numbers.increases_ && numbers.is_numeric_;
  if (numbers.is_numeric_) numbers.low_ = low, numbers.high_ = high;
  return numbers;
}

ColumnNumbers ColumnNumbers::of_clock(const std::vector<CsvTable>& tables, const std::string& heading,
                                      std::vector<std::string>& notes) {
  ColumnNumbers numbers;
  for (const CsvTable& table : tables) {
    LogStamps stamps = read_stamps(table, heading, 1.0);
    numbers.is_text_ = stamps.is_text;
    notes.insert(notes.end(), stamps.notes.begin(), stamps.notes.end());
    stamps.restarts.push_back(stamps.time_s.size());
    for (Index from = 0; const Index to : stamps.restarts) {
      if (to - from > 1) numbers.files_.emplace_back(stamps.start_s + stamps.time_s.segment(from, to - from).array());
      from = to;
    }
  }
  numbers.increases_ = numbers.is_numeric_ = !numbers.files_.empty();
  return numbers;
}

bool ColumnNumbers::is_whole() const {
  return is_numeric_ &&
         std::ranges::all_of(files_, [](const VectorXd& v) { return (v.array() == v.array().round()).all(); });
}

bool ColumnNumbers::counts_rows() const {
  return increases_ && is_whole() &&
         std::ranges::all_of(files_, [](const VectorXd& v) { return (steps_of(v).array() == 1.0).all(); });
}

bool ColumnNumbers::is_even() const {
  constexpr double kEven = 0.1;
  return increases_ && steps().deviation <= kEven;
}

bool ColumnNumbers::is_copy_of(const ColumnNumbers& other) const {
  return is_numeric_ && other.is_numeric_ &&
         std::ranges::equal(files_, other.files_,
                            [](const VectorXd& a, const VectorXd& b) { return a.size() == b.size() && a == b; });
}

ColumnNumbers::Steps ColumnNumbers::steps() const {
  Steps steps;
  std::vector<VectorXd> times;
  for (const VectorXd& values : files_) times.emplace_back(values.array() - values[0]);
  steps.median = median_step(times);
  for (const VectorXd& time : times) {
    const TimeGrid grid = fit_time_grid(time, 0.0);
    steps.duration += time[time.size() - 1];
    if (steps.median > 0.0) steps.deviation = std::max(steps.deviation, grid.deviation_s / steps.median);
  }
  return steps;
}

FullTurn full_turn(const ColumnNumbers& numbers, const std::string& unit) {
  struct Turn {
    double wrap;
    const char* unit;
  };
  constexpr auto kTurns = std::to_array<Turn>({{2.0 * std::numbers::pi, "rad"}, {360.0, "deg"}});
  constexpr double kNear = 0.25, kRange = 0.02, kHalf = 0.5 * (1.0 + kRange), kNearHalf = 0.45;  // shares of a turn
  const double range = numbers.high() - numbers.low();
  for (const Turn& turn : kTurns) {
    if (!unit.empty() && unit != turn.unit) continue;
    if (range > (1.0 + kRange) * turn.wrap || range < 0.5 * turn.wrap) continue;
    std::size_t jumps = 0, others = 0;
    for (const VectorXd& values : numbers.files()) {
      if (values.size() < 2) continue;
      for (const double step : steps_of(values)) {
        if (std::abs(step) <= 0.5 * turn.wrap) continue;
        ++(std::abs(std::abs(step) - turn.wrap) <= kNear * turn.wrap ? jumps : others);
      }
    }
    if (jumps > 0 && others == 0 && range >= (1.0 - kNear) * turn.wrap) return {turn.wrap, turn.unit, true};
    const double low = numbers.low() / turn.wrap, high = numbers.high() / turn.wrap;
    const bool is_one_turn = (low >= -kHalf && high <= kHalf) || (low >= 0.0 && high <= 2.0 * kHalf);
    const bool comes_near = std::max(-low, high) >= kNearHalf;
    if (!unit.empty() && others == 0 && is_one_turn && comes_near) return {turn.wrap, turn.unit, false};
  }
  return {};
}

}  // namespace nlo::trainer
