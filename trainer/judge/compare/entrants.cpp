// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/entrants.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "codegen/structures/structure_module.h"
#include "codegen/targets/cpp_cost.h"
#include "codegen/targets/prepared_export.h"
#include "trainer/judge/compare/filter_table.h"
#include "trainer/judge/evaluation/estimator_words.h"

namespace nlo::trainer {
namespace {

using Kind = Entrant::Kind;

StudyEstimator observer_column(const std::string& name, const codegen::Model& model) {
  StudyEstimator column{name, fmt::format("{} observer", codegen::structure_name(model)), true};
  const codegen::CppCost cost = codegen::cpp_cost(codegen::PreparedExport(model));
  column.operations = 2.0 * static_cast<double>(cost.multiply_adds());
  column.functions = static_cast<double>(cost.step_activations + cost.estimate_activations);
  column.state_bytes = static_cast<double>(cost.observer_bytes);
  column.constant_bytes = static_cast<double>(cost.constant_bytes);
  return column;
}

void add_simple(const std::string& name, const std::vector<NamedModel>& models, std::vector<Entrant>& entrants) {
  for (const NamedModel& model : models) {
    StudyEstimator column{name, std::string(estimator_words(name)->meaning)};
    if (name == "ridge" && models.size() > 1) column.name += " of " + model.name;
    entrants.push_back({Kind::kSimple, column, name, {&model}});
    if (name != "ridge") return;  // the others read no model
  }
}

StudyEstimator floor_column(const FilterContext& context, const PlantCost& plant, int particles) {
  StudyEstimator column{std::string(kParticle),
                        fmt::format("{}, {} particles: the floor", estimator_words(kParticle)->meaning, particles)};
  const double count = particles, nx = static_cast<double>(context.plant.nx);
  const StepCost each = plant.f * 4.0 + plant.h + StepCost{13.0 * nx + 2.0 * nx + 12.0, 1.0};
  column.operations = count * each.operations;
  column.functions = count * each.functions;
  column.state_bytes = 4.0 * count * (nx + 1.0);
  return column;
}

}  // namespace

std::vector<Entrant> strict_entrants(const std::vector<NamedModel>& models, const StudyTest& test, bool is_looped) {
  std::vector<const NamedModel*> all;
  for (const NamedModel& model : models) all.push_back(&model);
  const std::vector<const NamedModel*> first = {all.front()};
  std::vector<Entrant> entrants{{Kind::kObserver, {"observer", "", true}, "observer", all}};
  for (const std::string& name : test.against) {
    if (name == "constant" || name == "ridge") continue;  // part of every comparison
    const bool is_true = name == kTrueEkf, is_filter = is_true || find_filter(name) != nullptr;
    entrants.push_back({is_filter ? Kind::kFilter : Kind::kSimple, {name, ""}, is_true ? "ekf" : name, first, is_true});
  }
  entrants.push_back({Kind::kSimple, {"constant", ""}, "constant", first});
  entrants.push_back({Kind::kSimple, {"ridge", ""}, "ridge", all});
  if (!is_looped) return entrants;
  const std::vector<Entrant> open = entrants;
  for (const Entrant& each : open) {
    if (each.kind == Kind::kSimple || each.knows_changes) continue;
    entrants.push_back(each);
    entrants.back().column.name += "_in_loop";
    entrants.back().in_loop = true;
  }
  return entrants;
}

std::vector<Entrant> compared_entrants(const std::vector<NamedModel>& models, const Experiment& nominal,
                                       const std::vector<std::string>& joint_parameters, const StudyTest& test) {
  const auto wants = [&](std::string_view name) { return std::ranges::find(test.against, name) != test.against.end(); };
  const FilterContext context = filter_context(nominal, {}, joint_parameters);
  const PlantCost plant = plant_cost(*nominal.plant);
  std::vector<Entrant> entrants;
  for (const NamedModel& model : models)
    entrants.push_back({Kind::kObserver,
                        observer_column(models.size() == 1 ? "observer" : model.name, model.model),
                        "observer",
                        {&model}});
  for (const FilterRow& row : filter_table()) {
    if (!wants(row.name)) continue;
    const std::string name(row.name);
    StudyEstimator column{name, std::string(estimator_words(name)->meaning)};
    const StepCost cost = row.cost(context, plant);
    column.operations = cost.operations;
    column.functions = cost.functions;
    column.state_bytes = 4.0 * static_cast<double>(row.state(context));
    entrants.push_back({Kind::kFilter, column, name});
    if (!test.tune) continue;
    column.name += StudyEstimator::kTuned;
    column.meaning += ", tuned for each condition";
    entrants.push_back({Kind::kFilter, column, name});
  }
  for (const std::string& name : simple_names())
    if (wants(name)) add_simple(name, models, entrants);
  if (wants(kParticle))
    entrants.push_back({Kind::kFloor, floor_column(context, plant, test.particles), std::string(kParticle)});
  return entrants;
}

}  // namespace nlo::trainer
