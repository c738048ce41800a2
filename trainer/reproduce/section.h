// SPDX-License-Identifier: MIT
// The result of an item: our numbers beside the paper's, figures, and claims that hold or not. It only contains data;
// page.cpp writes HTML from it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/reproduce/contest.h"
#include "trainer/reproduce/exam_table.h"

namespace nlo::trainer::reproduction {

/// Mean and population standard deviation.
struct Spread {
  double mean = 0.0, deviation = 0.0;
};

/// Returns mean and spread of values over training seeds; NaN without values.
Spread spread(const std::vector<double>& values);

/// One number of the paper and our values for it, one per training seed. The paper's protocol allows two readings, so
/// the error is computed in two ways.
///   strict      norm = sqrt(mean |x - x_hat|^2), one noise draw per sample
///   paper_like  norm / RMS|x|, a new noise draw at every Runge-Kutta stage
struct Cell {
  std::optional<double> paper;
  std::vector<double> strict, paper_like;
};

struct ComparisonTable {
  std::string title;   ///< empty if the item has one table
  std::string corner;  ///< heading of the first column
  std::vector<std::string> columns, rows;
  std::vector<std::vector<Cell>> cells;  ///< rows x columns
};

/// A claim about the numbers, checked for each seed.
struct Ordering {
  std::string claim, reading;
  std::vector<bool> held;  ///< for each seed: true if the claim holds
};

/// Calls `holds` for each of `seeds` seeds.
template <class Holds>
Ordering per_seed(std::string claim, std::size_t seeds, const Holds& holds, std::string reading = "strict") {
  Ordering ordering{std::move(claim), std::move(reading), {}};
  for (std::size_t seed = 0; seed < seeds; ++seed) ordering.held.push_back(holds(seed));
  return ordering;
}

/// Claims that the strict error of `cell` is at most `limit`, or less than that of another cell.
Ordering at_most(std::string claim, const Cell& cell, double limit);
Ordering better(std::string claim, const Cell& cell, const Cell& than);

/// The reason why a cell differs from the paper's number.
struct Explanation {
  std::string row, column, text;  ///< an empty row or column means all
};

struct Section {
  std::string seen;  ///< our observation in words, generated from the numbers
  std::vector<ComparisonTable> tables;
  std::vector<Contest> contests;
  std::vector<ExamTable> exams;
  std::vector<Figure> figures;
  std::vector<Ordering> orderings;
  std::vector<Explanation> explanations;
  std::string csv;  ///< data of the figures; empty if there are none
};

/// A paper-like mean may differ from the paper's number by this share before the cell is marked.
constexpr double kTolerance = 0.35;

/// Returns mean / paper - 1 of the paper-like values; empty without a number of the paper.
std::optional<double> deviation_from_paper(const Cell& cell);

/// Returns true if the cell is marked: it differs from the paper by more than kTolerance.
bool is_outside(const Cell& cell);

}  // namespace nlo::trainer::reproduction
