// SPDX-License-Identifier: MIT
// Figure duff-exc: the reverse Duffing oscillator excited by u = cos 12t, with and without phi(z) u of (25).
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr const char* kExperiment = "reverse_duffing_driven";
constexpr double kSettledS = 5.0, kShownS = 15.0, kLimit = 0.015, kRatio = 4.0;
const Eigen::Vector2d kStart(-0.5, 0.5);
const std::vector<std::string> kInputs{"cos(12*t)"};

/// Draws |x - x_hat| over time with and without phi(z) u, because the lines of the states are too thick to show it.
Figure error_figure(const std::vector<Runs>& curves) {
  Figure figure;
  figure.caption = "Error norm of the same runs; the vertical axis is logarithmic.";
  figure.width = 1120;
  figure.panel_height = 240;
  Panel panel;
  panel.x_label = "time [s]";
  panel.y_label = "error";
  panel.log_y = true;
  panel.x_high = kShownS;
  panel.y_low = 1e-4;
  panel.y_high = 2.0;
  int colour = 0;
  for (const Runs& runs : curves) {
    const EvaluatedRun& run = runs.by_seed.front();
    const Eigen::VectorXd error = (run.truth.states - run.estimate).colwise().norm();
    const auto shown = static_cast<Eigen::Index>((run.truth.time_s.array() <= kShownS).count());
    panel.series.push_back({runs.title,
                            Series::Style::kLine,
                            colour++,
                            thinned(run.truth.time_s.head(shown)),
                            thinned(error.head(shown)).cwiseMax(1e-4),
                            {}});
  }
  figure.panels.push_back(std::move(panel));
  return figure;
}

}  // namespace

Section duffing_driven(const Workbench& bench) {
  const Eigen::MatrixXd box = bench.test_states(kExperiment);
  std::vector<Runs> curves;
  ComparisonTable table{
      "", "after 5 s, u = cos 12t", {"from (-0.5, 0.5)", "from the training box"}, {"with phi(z) u", "without"}, {}};
  for (const bool drive : {true, false}) {
    const Trial run{kExperiment, kStart, {}, kInputs, drive}, set{kExperiment, box, {}, kInputs, drive};
    curves.push_back(runs_of(bench, run, drive ? "with phi(z) u" : "without phi(z) u", drive ? "with" : "without"));
    table.cells.push_back({bench.measure(run, std::nullopt, kSettledS), bench.measure(set, std::nullopt, kSettledS)});
    bench.progress(drive ? 0.5 : 1.0);
  }
  Section section;
  section.figures = {runs_figure(curves, kShownS, "x(0) = (-0.5, 0.5), u = cos 12t, no noise."), error_figure(curves)};
  section.csv = runs_csv(curves);
  const Cell &with = table.cells[0][0], &without = table.cells[1][0];
  section.orderings = {
      at_most("with phi(z) u the error after 5 s is at most 0.015 (this run)", with, kLimit),
      per_seed("with phi(z) u the error is at most a quarter of the error without it", with.strict.size(),
               [&](std::size_t s) { return kRatio * with.strict[s] <= without.strict[s]; })};
  section.seen = fmt::format(
      "After 5 s, the error (strict) of this run is {} with phi(z) u and {} without it. Over the training box, the "
      "errors are {} and "
      "{}.",
      spread_text(with.strict), spread_text(without.strict), spread_text(table.cells[0][1].strict),
      spread_text(table.cells[1][1].strict));
  section.tables.push_back(std::move(table));
  return section;
}

}  // namespace nlo::trainer::reproduction
