// SPDX-License-Identifier: MIT
#include "trainer/reproduce/trajectories.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/judge/evaluation/text.h"
#include "trainer/reproduce/numbers_csv.h"

namespace nlo::trainer::reproduction {
namespace {

using Style = Series::Style;

constexpr std::uint64_t kNoiseSeed = 1;
constexpr int kTruthColour = 5, kEstimateColour = 1, kMeasurementColour = 0;

Eigen::VectorXd shown(const Eigen::VectorXd& values, Eigen::Index samples) {
  return thinned(values.head(samples), 500);
}

/// Returns the range of one state over all columns, slightly widened.
std::pair<double, double> common_range(const std::vector<Runs>& columns, Eigen::Index state, Eigen::Index samples) {
  double low = 1e300, high = -1e300;
  for (const Runs& runs : columns) {
    const EvaluatedRun& run = runs.by_seed.front();
    for (const auto* values : {&run.truth.states, &run.estimate}) {
      low = std::min(low, values->row(state).head(samples).minCoeff());
      high = std::max(high, values->row(state).head(samples).maxCoeff());
    }
  }
  const double margin = 0.08 * (high - low);
  return {low - margin, high + margin};
}

}  // namespace

Runs runs_of(const Workbench& bench, const Trial& trial, std::string title, std::string key) {
  const Dataset clean = bench.truth(trial);
  Runs runs{std::move(title), std::move(key), {}};
  for (int seed = 0; seed < bench.seeds; ++seed)
    runs.by_seed.push_back(
        evaluate_on_plant(bench.observer(trial, seed), clean, trial.noise, kNoiseSeed, 1).examples.front());
  return runs;
}

double error_between(const EvaluatedRun& run, double from_s, double to_s) {
  constexpr double kSlackS = 1e-6;  // 10 s in steps of 0.02 s may be computed as 9.99999 s
  double squares = 0.0;
  int samples = 0;
  for (Eigen::Index k = 0; k < run.truth.samples(); ++k) {
    const double t = run.truth.time_s[k];
    if (t < from_s - kSlackS || t > to_s + kSlackS) continue;
    squares += (run.truth.states.col(k) - run.estimate.col(k)).squaredNorm();
    ++samples;
  }
  return std::sqrt(squares / std::max(samples, 1));
}

std::vector<double> errors_between(const Runs& runs, double from_s, double to_s) {
  std::vector<double> errors;
  for (const EvaluatedRun& run : runs.by_seed) errors.push_back(error_between(run, from_s, to_s));
  return errors;
}

Figure runs_figure(const std::vector<Runs>& columns, double seconds, std::string caption) {
  Figure figure;
  figure.caption = std::move(caption);
  figure.columns = static_cast<int>(columns.size());
  figure.width = columns.size() == 1 ? 760 : 1120;
  figure.panel_height = 215;
  figure.common_legend = true;
  const EvaluatedRun& first = columns.front().by_seed.front();
  const double period_s = first.truth.time_s[1] - first.truth.time_s[0];
  const Eigen::Index samples =
      std::min(first.truth.samples(), static_cast<Eigen::Index>(std::lround(seconds / period_s)) + 1);
  for (Eigen::Index state = 0; state < first.truth.states.rows(); ++state) {
    const auto [low, high] = common_range(columns, state, samples);
    for (const Runs& runs : columns) {
      const EvaluatedRun& run = runs.by_seed.front();
      const Eigen::VectorXd time_s = shown(run.truth.time_s, samples);
      Panel panel;
      panel.x_label = state + 1 == first.truth.states.rows() ? "time [s]" : "";
      panel.y_label = &runs == &columns.front() ? fmt::format("x{}", state + 1) : "";
      panel.title = state == 0 ? runs.title : "";
      panel.x_high = seconds;
      panel.y_low = low;
      panel.y_high = high;
      // In the paper's examples, the output is the first state.
      const bool measured = state == 0 && (run.measured - run.truth.outputs).cwiseAbs().maxCoeff() > 0.0;
      const bool legend = state == 0 && &runs == &columns.back();
      if (measured)
        panel.series.push_back({legend ? "measured" : "",
                                Style::kDots,
                                kMeasurementColour,
                                time_s,
                                shown(run.measured.row(0), samples),
                                {}});
      panel.series.push_back({legend ? "truth" : "",
                              Style::kBroadLine,
                              kTruthColour,
                              time_s,
                              shown(run.truth.states.row(state), samples),
                              {}});
      panel.series.push_back({legend ? "estimate" : "",
                              Style::kLine,
                              kEstimateColour,
                              time_s,
                              shown(run.estimate.row(state), samples),
                              {}});
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

std::string runs_csv(const std::vector<Runs>& columns) {
  std::vector<std::pair<std::string, Eigen::VectorXd>> data{{"time_s", columns.front().by_seed.front().truth.time_s}};
  for (const Runs& runs : columns) {
    const EvaluatedRun& run = runs.by_seed.front();
    for (Eigen::Index i = 0; i < run.truth.states.rows(); ++i)
      data.emplace_back(fmt::format("{}_x{}", runs.key, i + 1), run.truth.states.row(i));
    for (Eigen::Index i = 0; i < run.measured.rows(); ++i)
      data.emplace_back(run.measured.rows() == 1 ? runs.key + "_y" : fmt::format("{}_y{}", runs.key, i + 1),
                        run.measured.row(i));
    for (Eigen::Index i = 0; i < run.estimate.rows(); ++i)
      data.emplace_back(fmt::format("{}_x{}_hat", runs.key, i + 1), run.estimate.row(i));
  }
  return columns_csv(data);
}

std::string spread_text(const std::vector<double>& values) {
  const Spread s = spread(values);
  return to_text(trainer::Spread{s.mean, values.size() < 2 ? std::nullopt : std::optional(s.deviation)});
}

}  // namespace nlo::trainer::reproduction
