// SPDX-License-Identifier: MIT
// Example 1: the Luenberger-like observer (15).
#include <fmt/format.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr const char* kAdam = "example1";
constexpr const char* kGradientDescent = "example1_gradient_descent";
constexpr double kStabilisedS = 5.0, kLimit = 0.10, kHalfBox = 5.0;
const Eigen::Vector2d kStart(2.0, -3.0);  // "an arbitrary given initial condition"

/// Returns the test states whose runs stay in the training box. The others follow an orbit of radius 10.
Eigen::MatrixXd staying_in_box(const Workbench& bench, const Eigen::MatrixXd& initial) {
  const Dataset runs = bench.truth({kAdam, initial});
  Eigen::MatrixXd kept(initial.rows(), initial.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < initial.cols(); ++i)
    if (runs.trajectories[static_cast<std::size_t>(i)].states.cwiseAbs().maxCoeff() <= kHalfBox)
      kept.col(count++) = initial.col(i);
  return kept.leftCols(count);
}

}  // namespace

Section luenberger_like(const Workbench& bench) {
  const std::vector<Runs> curves{runs_of(bench, {kAdam, kStart}, "Adam", "adam"),
                                 runs_of(bench, {kGradientDescent, kStart}, "gradient descent", "gradient_descent")};
  Section section;
  section.figures.push_back(
      runs_figure(curves, 20.0, "x(0) = (2, -3); the observer starts at zero, with the gain G = (4, 4). No noise."));
  section.csv = runs_csv(curves);
  const Eigen::MatrixXd box = bench.test_states(kAdam), inside = staying_in_box(bench, box);
  ComparisonTable table{"",
                        "after 5 s",
                        {"this run", "from the training box", "runs that stay in it"},
                        {"Adam, random stretches of runs", "gradient descent, full batches"},
                        {}};
  for (const char* experiment : {kAdam, kGradientDescent}) {
    auto& row = table.cells.emplace_back();
    for (const Eigen::MatrixXd& initial : {Eigen::MatrixXd(kStart), box, inside})
      row.push_back(bench.measure({experiment, initial}, std::nullopt, kStabilisedS));
    bench.progress(0.5 * static_cast<double>(table.cells.size()));
  }
  section.orderings = {
      at_most("error at most 0.10 after 5 s for runs that stay in the training box", table.cells[0][2], kLimit)};
  section.seen = fmt::format(
      "After 5 s, the error (strict) is {} in this run, {} over the training box, and {} for the runs in which the "
      "plant stays in the box ({} of {} runs). The other runs follow an orbit of radius 10, where g_hat had little "
      "training data. The paper does not state its gain, which determines the remaining error.",
      spread_text(table.cells[0][0].strict), spread_text(table.cells[0][1].strict),
      spread_text(table.cells[0][2].strict), inside.cols(), box.cols());
  section.tables.push_back(std::move(table));
  return section;
}

}  // namespace nlo::trainer::reproduction
