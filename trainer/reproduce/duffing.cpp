// SPDX-License-Identifier: MIT
// The paper's figures of example 3: the reverse Duffing oscillator inside and outside of the training box.
#include <fmt/format.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/numbers_csv.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

/// Returns sqrt(mean over a run of |x - x_hat|^2), without noise, for a plant of two states: x2.size() x x1.size().
///   x1, x2   initial states along each axis
///   threads  0: all cores; does not affect the result
/// Throws codegen::Error if a run overflows.
Eigen::MatrixXd rmse_map(const codegen::Model& model, const PlantConfig& plant, const SimulationConfig& simulation,
                         const Eigen::VectorXd& x1, const Eigen::VectorXd& x2, int threads) {
  Eigen::MatrixXd map(x2.size(), x1.size());
  ThreadPool(threads).run(static_cast<int>(x2.size()), [&](int row, int) {
    Eigen::MatrixXd initial(2, x1.size());
    initial.row(0) = x1.transpose();
    initial.row(1).setConstant(x2[row]);
    const Dataset runs = simulate_from(*make_plant(plant), simulation, initial);
    codegen::ReferenceObserver<float> observer(model);
    for (Eigen::Index column = 0; column < x1.size(); ++column) {
      const Trajectory& run = runs.trajectories[static_cast<std::size_t>(column)];
      const Eigen::MatrixXd estimate = observer.run(run.outputs, {}, run.time_s, true).x_hat;
      map(row, column) = std::sqrt((run.states - estimate).squaredNorm() / static_cast<double>(run.samples()));
    }
  });
  return map;
}

constexpr const char* kOnX1 = "reverse_duffing_x1";
constexpr const char* kOnX2 = "reverse_duffing_x2";
constexpr double kReachX2 = 3.0;

/// Returns initial states in X2 outside of X1, as many as the test set has.
Eigen::MatrixXd outside_x1(const Workbench& bench) {
  Workbench wider = bench;
  wider.size.test_trajectories = 2 * bench.size.test_trajectories;  // enough, because X1 is only a ninth of X2
  const Eigen::MatrixXd drawn = wider.test_states(kOnX2);
  Eigen::MatrixXd kept(drawn.rows(), bench.size.test_trajectories);
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < drawn.cols() && count < kept.cols(); ++i)
    if (drawn.col(i).cwiseAbs().maxCoeff() > 1.0) kept.col(count++) = drawn.col(i);
  return kept.leftCols(count);
}

/// Returns the RMSE for each initial state as the root mean square over the training seeds, map_points x map_points
/// (row: x2, column: x1).
Eigen::MatrixXd mean_map(const Workbench& bench, std::string_view experiment, const Eigen::VectorXd& axis,
                         double from) {
  const Experiment& made_by = bench.experiment(experiment);
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(axis.size(), axis.size());
  for (int seed = 0; seed < bench.seeds; ++seed) {
    squares += rmse_map(bench.model(experiment, seed), *made_by.plant, made_by.simulation, axis, axis, bench.threads)
                   .cwiseAbs2();
    bench.progress(from + 0.4 * (seed + 1) / bench.seeds);
  }
  return (squares / bench.seeds).cwiseSqrt();
}

Series box(double half_width, int colour) {
  Eigen::VectorXd x(5), y(5);
  x << -half_width, half_width, half_width, -half_width, -half_width;
  y << -half_width, -half_width, half_width, half_width, -half_width;
  return {"", Series::Style::kDashes, colour, x, y, {}};
}

Panel map_panel(const Eigen::VectorXd& axis, const Eigen::MatrixXd& values, double low, double high,
                const char* title) {
  Panel panel;
  panel.title = title;
  panel.x_label = "x1(0)";
  panel.y_label = "x2(0)";
  const double half_cell = 0.5 * (axis[1] - axis[0]);
  panel.x_low = panel.y_low = -kReachX2 - half_cell;
  panel.x_high = panel.y_high = kReachX2 + half_cell;
  panel.heat_map = HeatMap{"RMSE over 50 s", axis, axis, values, low, high, true, true};
  return panel;
}

/// Makes a section with the errors of single runs without noise, a row for each curve.
Section single_runs(const Workbench& bench, const std::vector<std::string_view>& experiments,
                    const Eigen::Vector2d& start, const std::vector<std::string>& titles, double shown_s,
                    const char* caption) {
  std::vector<Runs> curves;
  Section section;
  ComparisonTable table{"", "observer", {"error of this run"}, {}, {}};
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    curves.push_back(runs_of(bench, {experiments[i], start}, titles[i], i == 0 ? "on_x1" : "on_x2"));
    table.rows.push_back(titles[i]);
    table.cells.push_back({bench.measure({experiments[i], start})});
    section.seen += fmt::format("{}{}: error (strict) {} over 50 s, {} after 10 s.", section.seen.empty() ? "" : " ",
                                titles[i], spread_text(errors_between(curves.back(), 0.0, 50.0)),
                                spread_text(errors_between(curves.back(), 10.0, 50.0)));
  }
  section.tables.push_back(std::move(table));
  section.figures.push_back(runs_figure(curves, shown_s, caption));
  section.csv = runs_csv(curves);
  return section;
}

}  // namespace

Section duffing_map(const Workbench& bench) {
  const Eigen::VectorXd axis = Eigen::VectorXd::LinSpaced(bench.size.map_points, -kReachX2, kReachX2);
  const Eigen::MatrixXd on_x1 = mean_map(bench, kOnX1, axis, 0.0), on_x2 = mean_map(bench, kOnX2, axis, 0.4);
  const double low = std::min(on_x1.minCoeff(), on_x2.minCoeff()), high = std::max(on_x1.maxCoeff(), on_x2.maxCoeff());

  Section section;
  Figure figure;
  figure.caption = fmt::format(
      "RMSE over 50 s for each of {0} x {0} initial states, without noise (root mean square over the training seeds). "
      "Both maps share one logarithmic colour scale. Dashed: the training box.",
      bench.size.map_points);
  figure.width = 1060;
  figure.panel_height = 470;
  figure.columns = 2;
  figure.panels = {map_panel(axis, on_x1, low, high, "trained on X1 = [-1, 1] x [-1, 1]"),
                   map_panel(axis, on_x2, low, high, "trained on X2 = [-3, 3] x [-3, 3]")};
  figure.panels[0].heat_map->show_scale = false;
  figure.panels[0].series.push_back(box(1.0, 1));
  figure.panels[1].series.push_back(box(kReachX2, 1));
  section.figures.push_back(std::move(figure));

  const Eigen::Index n = axis.size();
  section.csv = columns_csv({{"x1", axis.transpose().replicate(n, 1).reshaped()},
                             {"x2", axis.replicate(n, 1)},
                             {"rmse_trained_on_x1", on_x1.reshaped()},
                             {"rmse_trained_on_x2", on_x2.reshaped()}});

  const Eigen::MatrixXd inside = bench.test_states(kOnX1), outside = outside_x1(bench);
  ComparisonTable table{"", "initial states", {"from X1", "from X2 \\ X1"}, {"trained on X1", "trained on X2"}, {}};
  for (const char* experiment : {kOnX1, kOnX2}) {
    table.cells.push_back({bench.measure({experiment, inside}), bench.measure({experiment, outside})});
    bench.progress(experiment == kOnX1 ? 0.9 : 1.0);
  }
  section.orderings = {
      at_most("trained on X1: error at most 0.13 from X1", table.cells[0][0], 0.13),
      at_most("trained on X2: error at most 0.20 from X2 \\ X1", table.cells[1][1], 0.20),
      better("outside of X1, the observer trained on X2 has the smaller error", table.cells[1][1], table.cells[0][1])};
  section.seen = fmt::format(
      "From initial states outside of X1, the error is {} for the observer trained on X1 and {} for the observer "
      "trained on X2. From initial states inside of X1, the errors are {} and {}.",
      spread_text(table.cells[0][1].strict), spread_text(table.cells[1][1].strict),
      spread_text(table.cells[0][0].strict), spread_text(table.cells[1][0].strict));
  section.tables.push_back(std::move(table));
  return section;
}

Section duffing_from_2_0(const Workbench& bench) {
  return single_runs(bench, {kOnX1, kOnX2}, {2.0, 0.0}, {"trained on X1", "trained on X2"}, 20.0,
                     "x(0) = (2, 0): outside of X1, inside of X2. No noise.");
}

Section duffing_unexcited(const Workbench& bench) {
  return single_runs(bench, {kOnX1}, {-0.5, 0.5}, {"trained on X1"}, 30.0, "x(0) = (-0.5, 0.5), no input, no noise.");
}

}  // namespace nlo::trainer::reproduction
