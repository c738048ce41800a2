// SPDX-License-Identifier: MIT
// Single runs from a given initial state, as the paper's figures show them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/reproduce/section.h"
#include "trainer/reproduce/workbench.h"

namespace nlo::trainer::reproduction {

/// One curve of a figure: the runs of an observer from one initial state with strict noise, one per training seed.
struct Runs {
  std::string title;  ///< title of its panels: "{-5, -6, -7}"
  std::string key;    ///< prefix of its CSV columns: "fast"
  std::vector<EvaluatedRun> by_seed;
};

/// Returns the runs of the trial's observers, one per seed, from the trial's first initial state.
Runs runs_of(const Workbench& bench, const Trial& trial, std::string title, std::string key);

/// Returns sqrt(mean |x - x_hat|^2) over from_s <= t <= to_s.
double error_between(const EvaluatedRun& run, double from_s, double to_s);

/// Returns error_between() for each seed.
std::vector<double> errors_between(const Runs& runs, double from_s, double to_s);

/// Returns a figure with a row of panels per state and a column per observer. A panel shows the truth, the estimate of
/// the first seed and, if it is noisy and measures this state, the measurement. Panels of a row have the same axes.
Figure runs_figure(const std::vector<Runs>& columns, double seconds, std::string caption);

/// Returns a CSV text with time_s, then for each observer the truth, the measurement and the estimate of the first
/// seed: KEY_x1, ..., KEY_y, KEY_x1_hat, ...
std::string runs_csv(const std::vector<Runs>& columns);

/// Returns mean and standard deviation as "0.123 ± 0.004".
std::string spread_text(const std::vector<double>& values);

}  // namespace nlo::trainer::reproduction
