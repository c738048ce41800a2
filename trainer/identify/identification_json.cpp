// SPDX-License-Identifier: MIT
#include <cmath>

#include "trainer/evaluation/json_numbers.h"
#include "trainer/identify/identification_text.h"

namespace nlo::trainer {
namespace {

Json fitted_json(const std::vector<FittedError>& errors) {
  Json json = Json::object();
  for (const FittedError& error : errors)
    json[error.name] = {
        {"rmse", json_number(error.rmse)}, {"unit", error.unit}, {"correlation", json_number(error.correlation)}};
  return json;
}

Json entry_json(const LogEntry& entry) {
  std::string setup = entry.setup;
  for (const std::string& each : entry.describe)
    if (entry.setup.empty() && setup.find(each) == std::string::npos) setup += (setup.empty() ? "" : ", ") + each;
  Json json = {{"setup", setup}};
  if (entry.cost.operations > 0.0) {
    json["operations"] = std::round(entry.cost.operations);
    json["functions"] = std::round(entry.cost.functions);
  }
  for (const StateError& state : entry.metrics.pooled)
    for (std::size_t w = 0; w < entry.metrics.windows.size(); ++w)
      json["rmse"][state.name][entry.metrics.windows[w].name] = json_number(state.rmse[w]);
  return json;
}

}  // namespace

std::string identification_json(const std::string& name, const IdentificationResult& result, const FilterStudy* study) {
  Json json = {{"identification", name}, {"outcome", result.outcome}, {"iterations", result.iterations}};
  Json& parameters = json["parameters"] = Json::object();
  for (const ParameterEstimate& p : result.parameters)
    parameters[p.name] = {{"value", json_number(p.value)},
                          {"standard_error", json_number(p.standard_error)},
                          {"standard_error_by_segments", json_number(p.clustered_error)},
                          {"fixed", p.fixed},
                          {"identified", !p.unidentified},
                          {"at_bound", p.at_bound}};
  json["segments"] = result.segments;
  json["samples"] = result.samples;
  json["residuals"] = result.residuals;
  json["degrees_of_freedom"] = result.degrees_of_freedom;
  json["residual_deviation"] = json_number(result.residual_deviation);
  json["condition"] = json_number(result.condition);
  json["training"] = fitted_json(result.training);
  json["test"] = fitted_json(result.test);
  if (study != nullptr) {
    json["tuned_on"] = study->tuned_on;
    json["judged_on"] = study->judged_on;
    Json& estimators = json["estimators"] = Json::object();
    for (const LogEntry& entry : study->entries) estimators[entry.estimator] = entry_json(entry);
  }
  return json_text(json) + "\n";
}

}  // namespace nlo::trainer
