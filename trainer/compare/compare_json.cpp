// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>

#include "trainer/compare/compare_text.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json cell_json(const Comparison& comparison, const CompareCell& cell) {
  if (!cell.missing.empty()) return {{"norm", nullptr}, {"missing", cell.missing}};
  Json json = {{"norm", number(cell.mean())}};
  const auto error = cell.standard_error();
  json["standard_error"] = error ? number(*error) : Json(nullptr);
  const auto each = static_cast<std::size_t>(comparison.test.trajectories);
  json["worst"] = {{"norm", number(cell.worst)},
                   {"seed", comparison.test.seed + cell.worst_run / each},
                   {"run", cell.worst_run % each}};
  json["by_seed"] = Json::array();
  for (const double norm : cell.norms) json["by_seed"].push_back(number(norm));
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
               {"horizon_s", number(comparison.horizon_s)},
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
                         {"operations", number(column.operations)},
                         {"functions", number(column.functions)},
                         {"state_bytes", number(column.state_bytes)},
                         {"constant_bytes", number(column.constant_bytes)},
                         {"ns", number(column.ns)}};
  json["left_out"] = comparison.left_out;
  json["findings"] = comparison_findings(comparison);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace nlo::trainer
