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

/// One curve of a figure: an observer, where it starts, and its runs with strict noise, one per training seed.
struct Runs {
  std::string title;  ///< title of its panels: "{-5, -6, -7}"
  std::string key;    ///< prefix of its CSV columns: "fast"
  std::vector<EvaluatedRun> by_seed;
};

/// The runs of a trial's observers, one per seed, from its first initial state.
Runs runs_of(const Workbench& bench, const Trial& trial, std::string title, std::string key);

/// sqrt(mean |x - x_hat|^2) over from_s <= t <= to_s.
double error_between(const EvaluatedRun& run, double from_s, double to_s);

/// error_between() for each seed.
std::vector<double> errors_between(const Runs& runs, double from_s, double to_s);

/// A row of panels per state, a column per observer: truth, estimate of the first seed, and the measurement where it is
/// noisy and measures that state. The same axes in a row.
Figure runs_figure(const std::vector<Runs>& columns, double seconds, std::string caption);

/// time_s, then for each observer truth, measurement and estimate of the first seed: KEY_x1, ..., KEY_y, KEY_x1_hat,
/// ...
std::string runs_csv(const std::vector<Runs>& columns);

/// "0.123 ± 0.004".
std::string spread_text(const std::vector<double>& values);

}  // namespace nlo::trainer::reproduction
