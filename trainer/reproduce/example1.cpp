// SPDX-License-Identifier: MIT
// Example 1: the Luenberger-like observer (15).
#include <fmt/format.h>

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr const char* kExperiment = "example1";
constexpr double kStabilisedS = 5.0, kLimit = 0.10;
const Eigen::Vector2d kStart(2.0, -3.0);  // "an arbitrary given initial condition"

}  // namespace

Section luenberger_like(const Workbench& bench) {
  const std::vector<Runs> curves{runs_from(bench, kExperiment, kStart, {}, "x(0) = (2, -3)", "luenberger")};
  Section section;
  section.figures.push_back(runs_figure(curves, 30.0, "The observer starts at zero. No noise."));
  section.csv = runs_csv(curves);
  const Eigen::MatrixXd box = bench.test_states(kExperiment);
  ComparisonTable table{"", "initial states", {"0-50 s", "after 5 s"}, {"this run", "the training box"}, {}};
  for (const Eigen::MatrixXd& initial : {Eigen::MatrixXd(kStart), box}) {
    table.cells.push_back({bench.measure(kExperiment, initial, {}),
                           bench.measure(kExperiment, initial, {}, std::nullopt, kStabilisedS)});
    bench.progress(0.5 * static_cast<double>(table.cells.size()));
  }
  Ordering limit{"error at most 0.10 after 5 s, from the training box", "strict", {}};
  for (const double error : table.cells[1][1].strict) limit.held.push_back(error <= kLimit);
  section.orderings.push_back(std::move(limit));
  section.seen = fmt::format("After 5 s the error (strict) is {} in this run and {} over the training box.",
                             spread_text(table.cells[0][1].strict), spread_text(table.cells[1][1].strict));
  section.tables.push_back(std::move(table));
  return section;
}

}  // namespace nlo::trainer::reproduction
