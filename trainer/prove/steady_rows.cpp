// SPDX-License-Identifier: MIT
// Rows about the error that remains after an observer has forgotten its start.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/forward_spline.h"
#include "trainer/prove/steady_error.h"
#include "trainer/prove/steady_falsifier.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kMostCells = 4096;

/// Returns the reason why this model has no such rows; empty if it has them.
std::string reason_against(const codegen::Model& model, const CertifyOptions& options) {
  if (std::string why = reason_against_plant(model, options); !why.empty()) return why;
  if (static_cast<std::size_t>(model.nx()) > ForwardSpline::kMostStates)
    return fmt::format("the proof needs a plant with at most {} states", ForwardSpline::kMostStates);
  return {};
}

/// Returns a whole box as a region of as many equal cells as allowed, a power of two for each state.
StateRegion all_of(const StateBox& box) {
  int per_state = 1;
  while (std::pow(2.0 * per_state, box.centre.size()) <= static_cast<double>(kMostCells)) per_state *= 2;
  return {box, per_state};
}

std::string at_state(const codegen::Model& model, const Eigen::VectorXd& x) {
  std::string text;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    text +=
        fmt::format("{}{} = {}", i == 0 ? "" : ", ", model.states[static_cast<std::size_t>(i)].name, significant(x(i)));
  return text;
}

}  // namespace

CertificateRows steady_rows(const codegen::Model& model, const CertifyOptions& options) {
  constexpr const char* kWhat = "|x_hat - x| once the observer has forgotten its start";
  constexpr int kRuns = 100;
  constexpr Eigen::Index kAttacks = 60;
  if (const std::string why = reason_against(model, options); !why.empty()) return {absent_row("steady", kWhat, why)};
  const Experiment& experiment = *options.experiment;
  const auto plant = make_plant(*experiment.plant);
  SteadyQuestion question{options.noise, options.disturbance};
  if (options.boxes > 0) question.boxes = options.boxes;
  SteadyError proof;
  SteadyFound found;
  std::string where_from;
  try {
    const SteadyStates states =
        steady_states(model, *plant, experiment.simulation, options.disturbance, kRuns, options.seed);
    const StateRegion region =
        options.box.centre.size() > 0 ? all_of(options.box) : StateRegion::around(states.visited, kMostCells);
    const Eigen::MatrixXd starts = options.box.centre.size() > 0 ? region.points(1, 1) : states.visited;
    Eigen::MatrixXd chosen(plant->nx(), std::min(kAttacks, starts.cols()));
    for (Eigen::Index i = 0; i < chosen.cols(); ++i) chosen.col(i) = starts.col(i * starts.cols() / chosen.cols());
    proof = steady_error(model, *experiment.plant, region, states, question);
    found = largest_steady_error(model, *plant, region, states, chosen, question);
    where_from = fmt::format(
        "assumed: the state stays in {} cells, which fill {} % of the box [{}] to [{}], {}", region.places().size(),
        significant(100.0 * region.share(), 3), at_state(model, region.box().centre - region.box().radius),
        at_state(model, region.box().centre + region.box().radius),
        options.box.centre.size() > 0 ? "given by --box" : fmt::format("visited by {} simulated runs", kRuns));
  } catch (const codegen::Error& error) {
    return {absent_row("steady", kWhat, error.what())};
  }
  CertificateRows rows;
  const auto add = [&](const std::string& id, const std::string& what, Eigen::Index i, double bound, double seen,
                       const std::string& where, const std::string& note) {
    const codegen::Channel& state = model.states[static_cast<std::size_t>(i)];
    CertificateRow row;
    row.id = fmt::format("{}.{}", id, state.name);
    row.what = what;
    row.unit = state.unit;
    row.bound = bound;
    row.found = seen;
    row.where = where;
    row.note = note;
    rows.push_back(std::move(row));
  };
  const std::string size = fmt::format("noise within {}, disturbance within {}", significant(options.noise),
                                       significant(options.disturbance));
  for (Eigen::Index i = 0; i < model.nx(); ++i)
    add("steady", fmt::format("{}, {}", kWhat, size), i, proof.bound(i), found.error(i),
        fmt::format("in {} simulated runs, with the signs of noise and disturbance that are worst for this state",
                    found.runs),
        fmt::format("{}; the bound is largest at {}", where_from, at_state(model, proof.where.col(i))));
  for (Eigen::Index i = 0; i < model.nx(); ++i)
    add("map", "|T*(T(x)) - x|: the same without noise and disturbance", i, proof.approximation(i),
        found.approximation(i), "over simulated runs",
        i > 0 ? ""
              : fmt::format("the residual of the spline in (5) is {} of the size of F y", significant(proof.residual)));
  return rows;
}

}  // namespace nlo::trainer
