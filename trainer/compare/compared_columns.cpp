// SPDX-License-Identifier: MIT
#include "trainer/compare/compared_columns.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/export/cpp_cost.h"
#include "codegen/export/prepared_export.h"
#include "codegen/structures/module.h"
#include "trainer/evaluation/estimator_words.h"

namespace nlo::trainer {
namespace {

constexpr std::string_view kParticle = "particle";

using Columns = std::vector<ComparedColumn>;

void add_observers(const std::vector<ComparedModel>& models, Columns& columns) {
  for (const ComparedModel& model : models) {
    CompareColumn column{models.size() == 1 ? "observer" : model.name,
                         fmt::format("{} observer", codegen::structure_name(model.model)), true};
    const codegen::PreparedExport prepared(model.model, {});
    const codegen::CppCost cost = codegen::cpp_cost(
        prepared.model(), *codegen::module_of(prepared.model()).cpp(prepared.source()), prepared.initialiser());
    column.operations = 2.0 * static_cast<double>(cost.step_multiply_adds + cost.estimate_multiply_adds);
    column.functions = static_cast<double>(cost.step_activations + cost.estimate_activations);
    column.state_bytes = static_cast<double>(cost.observer_bytes);
    column.constant_bytes = static_cast<double>(cost.constant_bytes);
    columns.push_back({column, {&model, nullptr, false}});
  }
}

void add_simple(const std::string& name, const std::vector<ComparedModel>& models, Columns& columns) {
  for (const ComparedModel& model : models) {
    CompareColumn column{name, std::string(estimator_words(name)->meaning)};
    if (name == "ridge" && models.size() > 1) column.name += " of " + model.name;
    columns.push_back({column, {&model, nullptr, false, name}});
    if (name != "ridge") return;  // the others read no model
  }
}

}  // namespace

std::vector<ComparedColumn> compared_columns(const std::vector<ComparedModel>& models, const Experiment& nominal,
                                             const std::vector<std::string>& joint_parameters,
                                             const CompareTest& test) {
  const auto wants = [&](std::string_view name) { return std::ranges::find(test.against, name) != test.against.end(); };
  const FilterContext context = filter_context(nominal, {}, joint_parameters);
  const PlantCost plant = plant_cost(*nominal.plant);
  Columns columns;
  add_observers(models, columns);
  for (const FilterRow& row : filter_table()) {
    if (!wants(row.name)) continue;
    CompareColumn column{std::string(row.name), std::string(estimator_words(row.name)->meaning)};
    const StepCost cost = row.cost(context, plant);
    column.operations = cost.operations;
    column.functions = cost.functions;
    column.state_bytes = 4.0 * static_cast<double>(row.state(context));
    columns.push_back({column, {nullptr, &row, false}});
    if (!test.tune) continue;
    column.name += CompareColumn::kTuned;
    column.meaning += ", tuned for each condition";
    columns.push_back({column, {nullptr, &row, true}});
  }
  for (const std::string& name : simple_names())
    if (wants(name)) add_simple(name, models, columns);
  if (!wants(kParticle)) return columns;
  CompareColumn column{std::string(kParticle),
                       fmt::format("{}, {} particles: the floor", estimator_words(kParticle)->meaning, test.particles)};
  const double count = test.particles, nx = static_cast<double>(context.plant.nx);
  const StepCost each = plant.f * 4.0 + plant.h + StepCost{13.0 * nx + 2.0 * nx + 12.0, 1.0};
  column.operations = count * each.operations;
  column.functions = count * each.functions;
  column.state_bytes = 4.0 * count * (nx + 1.0);
  columns.push_back({column, {}});
  return columns;
}

}  // namespace nlo::trainer
