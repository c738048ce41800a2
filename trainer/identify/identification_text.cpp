// SPDX-License-Identifier: MIT
#include "trainer/identify/identification_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/judge/evaluation/evaluation_text.h"
#include "trainer/judge/evaluation/json_numbers.h"

namespace nlo::trainer {
namespace {

std::string remark(const ParameterEstimate& p) {
  if (p.fixed) return "fixed";
  if (p.at_bound) return "at its bound";
  if (p.unidentified) return "not identified";
  if (!(2.0 * p.clustered_error < std::abs(p.value))) return "may be 0";
  return "";
}

std::string notes_of(const IdentificationResult& result) {
  std::string notes, unidentified;
  for (const ParameterEstimate& p : result.parameters)
    if (p.unidentified && !p.at_bound) unidentified += (unidentified.empty() ? "" : ", ") + p.name;
  if (!unidentified.empty())
    notes += fmt::format(
        "- {}: the logs do not determine {} (the condition number is {}): fix one parameter by [identify] fixed, or "
        "combine parameters\n",
        unidentified, unidentified.find(',') == std::string::npos ? "it" : "them separately",
        significant(result.condition, 2));
  constexpr double kFar = 10.0;
  if (result.residual_deviation > kFar)
    notes += fmt::format(
        "- residuals are {} times [identify] noise: the search may be stuck, or the model does not describe the plant. "
        "Try shorter segments (segment_s) and other starting values\n",
        significant(result.residual_deviation, 2));
  constexpr double kCorrelated = 0.5;
  for (const FittedError& error : result.training)
    if (error.correlation > kCorrelated)
      notes += fmt::format(
          "- residuals of {} are correlated from sample to sample ({}): the model differs from the rig. Use the "
          "standard errors by segments, which account for this\n",
          error.name, significant(error.correlation, 2));
  return notes.empty() ? "" : "\n" + notes;
}

}  // namespace

std::string to_text(const IdentificationResult& result) {
  std::string text =
      fmt::format("{} after {} iterations: {} residuals in {} segments, {} parameters found, deviation {}\n\n",
                  result.outcome, result.iterations, result.residuals, result.segments,
                  std::count_if(result.parameters.begin(), result.parameters.end(),
                                [](const ParameterEstimate& p) { return !p.fixed; }),
                  significant(result.residual_deviation));
  Table parameters{{"parameter", "start", "estimate", "standard error", "by segments", "remark"}};
  for (const ParameterEstimate& p : result.parameters) {
    const bool none = p.fixed || p.unidentified;
    parameters.add_row({p.name, significant(p.start, 4), significant(p.value, 5),
                        none ? "-" : significant(p.standard_error, 2), none ? "-" : significant(p.clustered_error, 2),
                        remark(p)});
  }
  text += parameters.to_text(2) + "\n";
  Table errors{{"RMSE over segments", "training", "test"}};
  for (std::size_t i = 0; i < result.training.size(); ++i)
    errors.add_row({with_unit(result.training[i].name, result.training[i].unit), significant(result.training[i].rmse),
                    result.test.empty() ? "-" : significant(result.test[i].rmse)});
  return text + errors.to_text(2) + notes_of(result);
}

std::string to_text(const FilterStudy& study) {
  std::string text = fmt::format("Estimates on {}; filters tuned on {}\n", study.judged_on, study.tuned_on);
  text += "\n" + log_table(study.entries, true).to_text(2) + "\n";
  for (const LogEntry& entry : study.entries)
    if (!entry.setup.empty()) text += fmt::format("{}: {}\n", entry.estimator, entry.setup);
  return text + "operations and functions: per step, counted (see nlo identify --help)\n";
}

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
