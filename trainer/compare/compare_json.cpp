// SPDX-License-Identifier: MIT
#include "trainer/compare/compare_text.h"
#include "trainer/evaluation/json_numbers.h"

namespace nlo::trainer {
namespace {

Json cell_json(const Comparison& comparison, const CompareCell& cell) {
  if (!cell.missing.empty()) return {{"norm", nullptr}, {"missing", cell.missing}};
  Json json = {{"norm", json_number(cell.mean())}};
  json["standard_error"] = json_number(cell.spread().test_set_error);
  const auto each = static_cast<std::size_t>(comparison.test.trajectories);
  json["worst"] = {{"norm", json_number(cell.worst)},
                   {"seed", comparison.test.seed + cell.worst_run / each},
                   {"run", cell.worst_run % each}};
  json["by_seed"] = json_numbers(cell.norms);
  if (!cell.tuning.empty()) json["tuning"] = cell.tuning;
  if (cell.restarts > 0) json["restarts"] = cell.restarts;
  return json;
}

Json condition_json(const Condition& condition) {
  Json json = {{"title", condition_title(condition)}, {"noise", format_noise(condition.noise)}};
  if (condition.parameter_factor != 1.0) json["parameter_factor"] = condition.parameter_factor;
  for (const auto& [name, value] : condition.parameters) json["parameters"][name] = value;
  if (!condition.process_noise.empty()) json["process_noise"] = condition.process_noise;
  if (condition.box_scale != 1.0) json["box_scale"] = condition.box_scale;
  if (!condition.changes.empty()) json["set"] = condition.changes;
  if (!condition.inputs.empty()) json["input"] = condition.inputs;
  if (!condition.input_noise.none()) json["input_noise"] = format_noise(condition.input_noise);
  return json;
}

}  // namespace

std::string comparison_json(const Comparison& comparison) {
  const CompareTest& test = comparison.test;
  Json json = {{"experiment", comparison.experiment},
               {"plant", comparison.plant},
               {"seed", test.seed},
               {"seeds", test.seeds},
               {"trajectories", test.trajectories},
               {"horizon_s", json_number(comparison.horizon_s)},
               {"tuning_trajectories", test.tune ? Json(test.tuning_trajectories) : Json(nullptr)},
               {"norm_of", comparison.normalised ? "states over their standard deviation" : "states"}};
  Json& conditions = json["conditions"] = Json::object();
  for (std::size_t i = 0; i < comparison.conditions.size(); ++i) {
    Json& entry = conditions[comparison.conditions[i].name] = condition_json(comparison.conditions[i]);
    for (std::size_t c = 0; c < comparison.columns.size(); ++c)
      entry["columns"][comparison.columns[c].name] = cell_json(comparison, comparison.cell(i, c));
  }
  Json& cost = json["cost"] = Json::object();
  for (const CompareColumn& column : comparison.columns)
    cost[column.name] = {{"meaning", column.meaning},
                         {"operations", json_number(column.operations)},
                         {"functions", json_number(column.functions)},
                         {"state_bytes", json_number(column.state_bytes)},
                         {"constant_bytes", json_number(column.constant_bytes)}};
  json["left_out"] = comparison.left_out;
  json["findings"] = comparison_findings(comparison);
  return json_text(json) + "\n";
}

}  // namespace nlo::trainer
