// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>

#include "trainer/analysis/evaluation_text.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
Json number(const std::optional<double>& value) {
  return value ? number(*value) : Json(nullptr);
}

Json numbers(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

Json metrics_json(const ErrorMetrics& metrics) {
  return {{"norm", number(metrics.norm)},
          {"nrmse", number(metrics.nrmse)},
          {"settled", number(metrics.settled)},
          {"per_component", numbers(metrics.per_component)},
          {"settling_time_s", number(metrics.settling_time_s)}};
}

Json names_json(const std::vector<Channel>& channels) {
  Json list = Json::array();
  for (const Channel& channel : channels) list.push_back({{"name", channel.name}, {"unit", channel.unit}});
  return list;
}

Json windows_json(const StateError& error) {
  return {
      {"all", number(error.rmse[0])}, {"after_2_s", number(error.rmse[1])}, {"from_0.5_to_5_s", number(error.rmse[2])}};
}

Json states_json(const std::vector<StateError>& states) {
  Json list = Json::array();
  for (const StateError& state : states) {
    Json entry = {{"name", state.name}, {"unit", state.unit}};
    entry["rmse"] = windows_json(state);
    list.push_back(std::move(entry));
  }
  return list;
}

/// Replaces what is not UTF-8 (a file name may hold any bytes) rather than failing on it.
std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string evaluation_json(const std::string& model, const std::vector<Evaluation>& evaluations, double box_scale) {
  Json json = {{"model", model}};
  if (evaluations.empty()) return dump(json);
  const Evaluation& first = evaluations.front();
  json.update(metrics_json(first.metrics));
  json["seed"] = first.seed;
  json["noise"] = format_noise(first.noise);
  json["trajectories"] = first.trajectories;
  json["horizon_s"] = number(first.horizon_s);
  json["box_scale"] = number(box_scale);
  Json& excitation = json["excitation"] = Json::object();
  for (const auto& [input, expression] : first.excitation) excitation[input] = expression;
  json["samples"] = first.metrics.samples;
  json["settled_per_component"] = numbers(first.metrics.settled_per_component);
  json["states"] = names_json(first.states);
  if (evaluations.size() > 1) {
    Json& against = json["against"] = Json::object();
    for (std::size_t i = 1; i < evaluations.size(); ++i)
      against[evaluations[i].estimator] = metrics_json(evaluations[i].metrics);
  }
  return dump(json);
}

std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation) {
  Json json = {{"model", model}};
  json.update(metrics_json(evaluation.metrics));
  if (!evaluation.one_unit) json["norm"] = json["nrmse"] = json["settled"] = nullptr;
  json["seed"] = evaluation.seed;
  json["noise"] = format_noise(evaluation.noise);
  json["samples"] = evaluation.metrics.samples;
  json["states"] = names_json(evaluation.states);

  const LogMetrics& observer = evaluation.entries.front().metrics;
  json["per_state"] = states_json(observer.pooled);
  for (std::size_t i = 0; i < observer.pooled.size(); ++i) {
    Json& against = json["per_state"][i]["against"] = Json::object();
    for (std::size_t e = 1; e < evaluation.entries.size(); ++e)
      against[evaluation.entries[e].estimator] = windows_json(evaluation.entries[e].metrics.pooled[i]);
  }
  json["baselines_fitted_on"] = evaluation.baselines_fitted_on;
  json["files"] = Json::array();
  for (const LogMetrics::File& file : observer.files)
    json["files"].push_back({{"source", file.source}, {"per_state", states_json(file.states)}});
  json["notes"] = evaluation.notes;
  return dump(json);
}

}  // namespace nlo::trainer
