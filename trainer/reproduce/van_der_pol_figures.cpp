// SPDX-License-Identifier: MIT
// The paper's figures of example 2: single runs of the Van der Pol oscillator.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

const NoiseConfig kNone{}, kGaussian{NoiseKind::kGaussian, 0.5};
const Eigen::Vector2d kStart(-0.5, 0.5);
constexpr double kShownS = 30.0, kTransientS = 10.0, kEndS = 50.0;

/// Returns the table of a figure: for each curve the strict and the paper-like error of the whole run.
ComparisonTable run_errors(const Workbench& bench, const std::vector<Runs>& curves,
                           const std::vector<std::string_view>& experiments, const Eigen::VectorXd& x0,
                           const std::vector<NoiseConfig>& noises) {
  ComparisonTable table{"", "observer", {"error of this run"}, {}, {}};
  for (std::size_t i = 0; i < curves.size(); ++i) {
    table.rows.push_back(curves[i].title);
    table.cells.push_back({bench.measure({experiments[i], x0, noises[i]})});
    bench.progress(static_cast<double>(i + 1) / static_cast<double>(curves.size()));
  }
  return table;
}

std::string early_and_late(const Runs& runs) {
  return fmt::format("{} in the first {:.0f} s and {} after", spread_text(errors_between(runs, 0.0, kTransientS)),
                     kTransientS, spread_text(errors_between(runs, kTransientS, kEndS)));
}

Section compared(const Workbench& bench, const NoiseConfig& noise, const char* caption) {
  const std::vector<std::string_view> experiments{"van_der_pol_baseline_fast", "van_der_pol_baseline_slow",
                                                  "van_der_pol_noise"};
  const std::vector<Runs> curves{runs_of(bench, {experiments[0], kStart, noise}, "fast D = {-5, -6, -7}", "fast"),
                                 runs_of(bench, {experiments[1], kStart, noise}, "slow D = {-0.1, -0.2, -0.3}", "slow"),
                                 runs_of(bench, {experiments[2], kStart, noise}, "learned with noise", "learned")};
  Section section;
  section.figures.push_back(runs_figure(curves, kShownS, caption));
  section.csv = runs_csv(curves);
  section.tables.push_back(run_errors(bench, curves, experiments, kStart, {noise, noise, noise}));
  section.seen = fmt::format("Error (strict): fast D {}; slow D {}; learned {}.", early_and_late(curves[0]),
                             early_and_late(curves[1]), early_and_late(curves[2]));
  const auto worse_than_learned = [&](std::size_t curve, double from_s, double to_s, const char* claim) {
    const std::vector<double> own = errors_between(curves[curve], from_s, to_s),
                              learned = errors_between(curves[2], from_s, to_s);
    section.orderings.push_back(per_seed(claim, own.size(), [&](std::size_t s) { return own[s] > learned[s]; }));
  };
  worse_than_learned(1, 0.0, kTransientS, "the slow D converges later than the learned one (error before 10 s)");
  if (!noise.none())
    worse_than_learned(0, kTransientS, kEndS,
                       "the fast D suffers more from noise than the learned one (error after 10 s)");
  return section;
}

/// Returns the section for one experiment, tested without and with noise.
Section without_and_with_noise(const Workbench& bench, std::string_view experiment, const char* caption) {
  const std::vector<Runs> curves{runs_of(bench, {experiment, kStart, kNone}, "without noise", "clean"),
                                 runs_of(bench, {experiment, kStart, kGaussian}, "with N(0, 0.5)", "noisy")};
  Section section;
  section.figures.push_back(runs_figure(curves, kShownS, caption));
  section.csv = runs_csv(curves);
  section.tables.push_back(run_errors(bench, curves, {experiment, experiment}, kStart, {kNone, kGaussian}));
  section.seen = fmt::format("Error (strict): without noise {}; with noise {}.", early_and_late(curves[0]),
                             early_and_late(curves[1]));
  return section;
}

}  // namespace

Section van_der_pol_with_noise(const Workbench& bench) {
  return compared(bench, kGaussian, "x(0) = (-0.5, 0.5), measurement noise N(0, 0.5) on y = x1, one draw per sample.");
}

Section van_der_pol_without_noise(const Workbench& bench) {
  return compared(bench, kNone, "x(0) = (-0.5, 0.5), no measurement noise.");
}

Section van_der_pol_regularised(const Workbench& bench) {
  return without_and_with_noise(bench, "van_der_pol_regularised",
                                "D learned with the penalty of (20), x(0) = (-0.5, 0.5).");
}

Section van_der_pol_regularised_from_2_0(const Workbench& bench) {
  const Eigen::Vector2d start(2.0, 0.0);
  const std::vector<Runs> curves{
      runs_of(bench, {"van_der_pol_regularised", start, kNone}, "from (2, 0)", "regularised")};
  Section section;
  section.figures.push_back(runs_figure(curves, kShownS,
                                        "D learned with the penalty of (20), x(0) = (2, 0): outside of the training "
                                        "box, close to the limit cycle."));
  const EvaluatedRun& run = curves.front().by_seed.front();
  Figure plane;
  plane.caption = "The same run in the plane of its states.";
  plane.width = 620;
  plane.panel_height = 400;
  Panel panel;
  panel.x_label = "x1";
  panel.y_label = "x2";
  panel.zero_line = panel.zero_column = true;
  panel.series.push_back({"truth", Series::Style::kBroadLine, 5, run.truth.states.row(0), run.truth.states.row(1), {}});
  panel.series.push_back({"estimate", Series::Style::kLine, 1, run.estimate.row(0), run.estimate.row(1), {}});
  plane.panels.push_back(std::move(panel));
  section.figures.push_back(std::move(plane));
  section.csv = runs_csv(curves);
  section.tables.push_back(run_errors(bench, curves, {"van_der_pol_regularised"}, start, {kNone}));
  section.seen = fmt::format("Error (strict): {}.", early_and_late(curves.front()));
  return section;
}

Section van_der_pol_without_robustness(const Workbench& bench) {
  return without_and_with_noise(bench, "van_der_pol_plain",
                                "D learned without noise and without a penalty, x(0) = (-0.5, 0.5).");
}

}  // namespace nlo::trainer::reproduction
