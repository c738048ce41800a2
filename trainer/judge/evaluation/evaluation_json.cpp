// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluation_text.h"
#include "trainer/judge/evaluation/json_numbers.h"

namespace nlo::trainer {
namespace {

/// A window that lasts to the end of a run has null as its end.
Json window_json(const EvaluationWindow& window) {
  return {{"name", window.name}, {"from_s", json_number(window.from_s)}, {"to_s", json_number(window.to_s)}};
}

const char* norm_of(bool normalised) {
  return normalised ? "states over their standard deviation" : "states";
}

/// Returns the numbers of one estimator. `number_of` returns the value of a quantity.
template <class NumberOf>
Json quantities_json(const ErrorMetrics& shape, NumberOf&& number_of) {
  const auto per_state = [&](auto&& value_of) {
    Json list = Json::array();
    for (Eigen::Index i = 0; i < shape.per_component.size(); ++i)
      list.push_back(number_of([&, i](const ErrorMetrics& m) -> std::optional<double> {
        const Eigen::VectorXd& values = value_of(m);
        return values.size() > i ? std::optional(values[i]) : std::nullopt;
      }));
    return list;
  };
  Json json;
  json["norm"] = number_of([](const ErrorMetrics& m) { return std::optional(m.norm); });
  json["nrmse"] = number_of([](const ErrorMetrics& m) { return m.nrmse; });
  json["settled"] = number_of([](const ErrorMetrics& m) { return m.settled; });
  json["per_component"] = per_state([](const ErrorMetrics& m) -> const Eigen::VectorXd& { return m.per_component; });
  json["settling_time_s"] = number_of([](const ErrorMetrics& m) { return m.settling_time_s; });
  json["windows"] = Json::array();
  for (std::size_t w = 0; w < shape.windows.size(); ++w) {
    Json entry = window_json(shape.windows[w].window);
    entry["norm"] = number_of([w](const ErrorMetrics& m) { return m.windows[w].norm; });
    entry["per_component"] =
        per_state([w](const ErrorMetrics& m) -> const Eigen::VectorXd& { return m.windows[w].per_component; });
    json["windows"].push_back(std::move(entry));
  }
  return json;
}

Json metrics_json(const StudyCell& cell) {
  const ErrorMetrics& shape = cell.first().metrics;
  const auto spread = [&](const Quantity& quantity) { return spread_of(cell, quantity); };
  Json json = quantities_json(shape, [&](const Quantity& quantity) {
    const auto found = spread(quantity);
    return found ? json_number(found->mean) : Json(nullptr);
  });
  if (cell.is_single()) return json;
  Json& errors = json["standard_error"];
  errors["over_test_sets"] = cell.test_sets() == 1 ? Json(nullptr) : quantities_json(shape, [&](const Quantity& q) {
    const auto found = spread(q);
    return found ? json_number(found->test_set_error) : Json(nullptr);
  });
  errors["over_training_seeds"] = cell.models() == 1 ? Json(nullptr) : quantities_json(shape, [&](const Quantity& q) {
    const auto found = spread(q);
    return found ? json_number(found->training_seed_error) : Json(nullptr);
  });
  return json;
}

Json loop_json(const ClosedLoopCost& loop) {
  Json json = {{"deviation", json_numbers(loop.deviation)}, {"runs", loop.runs}, {"left", loop.left}};
  if (loop.cost) json["cost"] = json_number(loop.cost);
  if (loop.of_true_state) json["cost_of_true_state"] = json_number(loop.of_true_state);
  return json;
}

/// Returns one entry per state.
Json coverage_json(const Coverage& coverage) {
  return {{"share_68", json_numbers(coverage.share_68)},
          {"share_95", json_numbers(coverage.share_95)},
          {"sigma", json_numbers(coverage.sigma)},
          {"unknown", json_numbers(coverage.unknown)}};
}

Json domain_json(const DomainShare& domain) {
  return {{"share", json_number(domain.share())},
          {"samples", domain.samples},
          {"first_samples", domain.runs},
          {"first_samples_inside", domain.first_inside}};
}

Json names_json(const std::vector<Channel>& channels) {
  Json list = Json::array();
  for (const Channel& channel : channels) list.push_back({{"name", channel.name}, {"unit", channel.unit}});
  return list;
}

/// Returns the RMSE by window name.
Json windows_json(const StateError& error, const EvaluationWindows& windows) {
  Json json = Json::object();
  for (std::size_t w = 0; w < windows.size(); ++w) json[windows[w].name] = json_number(error.rmse[w]);
  return json;
}

Json states_json(const std::vector<StateError>& states, const EvaluationWindows& windows) {
  Json list = Json::array();
  for (const StateError& state : states) {
    Json entry = {{"name", state.name}, {"unit", state.unit}};
    entry["rmse"] = windows_json(state, windows);
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

std::string evaluation_json(const StudyRow& row, double box_scale) {
  const Evaluation& first = row.observer().first();
  Json json = {{"model", row.models.front()}};
  json.update(metrics_json(row.observer()));
  json["seed"] = first.seed;
  json["noise"] = format_noise(first.noise);
  json["norm_of"] = norm_of(first.metrics.normalised);
  json["models"] = row.models;
  json["test_sets"] = row.observer().test_sets();
  json["trajectories"] = first.trajectories;
  json["horizon_s"] = json_number(first.horizon_s);
  json["box_scale"] = json_number(box_scale);
  Json& excitation = json["excitation"] = Json::object();
  for (const auto& [input, expression] : first.excitation) excitation[input] = expression;
  json["changed"] = first.changed;
  json["samples"] = first.metrics.samples;
  json["settled_per_component"] = json_numbers(first.metrics.settled_per_component);
  json["states"] = names_json(first.states);
  json["in_domain"] = domain_json(study_domain(row.observer()));
  if (const auto coverage = study_coverage(row.observer())) json["coverage"] = coverage_json(*coverage);
  for (const StudyCell& cell : std::span(row.cells).subspan(1)) {
    Json& entry = json["against"][cell.first().estimator] = metrics_json(cell);
    if (!cell.first().label.empty()) entry["label"] = cell.first().label;
    if (const auto loop = study_loop(cell)) entry["loop"] = loop_json(*loop);
    if (const auto coverage = study_coverage(cell)) entry["coverage"] = coverage_json(*coverage);
  }
  json["notes"] = study_notes(row);
  return json_text(json);
}

std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation) {
  Json json = {{"model", model}};
  const ErrorMetrics& metrics = evaluation.metrics;
  json.update(quantities_json(metrics, [&](const Quantity& quantity) { return json_number(quantity(metrics)); }));
  json["seed"] = evaluation.seed;
  json["noise"] = format_noise(evaluation.noise);
  if (!evaluation.missing.empty()) json["missing"] = evaluation.missing;
  if (evaluation.behind_gate) json["behind_gate"] = true;
  json["norm_of"] = norm_of(metrics.normalised);
  json["samples"] = metrics.samples;
  json["states"] = names_json(evaluation.states);

  const LogMetrics& observer = evaluation.entries.front().metrics;
  json["per_state"] = states_json(observer.pooled, observer.windows);
  for (std::size_t i = 0; i < observer.pooled.size(); ++i) {
    Json& against = json["per_state"][i]["against"] = Json::object();
    for (std::size_t e = 1; e < evaluation.entries.size(); ++e)
      against[evaluation.entries[e].estimator] =
          windows_json(evaluation.entries[e].metrics.pooled[i], observer.windows);
  }
  json["baselines_fitted_on"] = evaluation.baselines_fitted_on;
  json["files"] = Json::array();
  for (const LogMetrics::File& file : observer.files)
    json["files"].push_back({{"source", file.source}, {"per_state", states_json(file.states, observer.windows)}});
  json["unscored"] = {{"share", json_number(evaluation.unscored.share)}, {"where", evaluation.unscored.where}};
  if (!evaluation.unscored_states.empty()) json["unscored"]["states"] = evaluation.unscored_states;
  json["in_domain"] = domain_json(evaluation.domain);
  if (evaluation.coverage) json["coverage"] = coverage_json(*evaluation.coverage);
  if (evaluation.widened_coverage) json["widened_coverage"] = coverage_json(*evaluation.widened_coverage);
  json["notes"] = evaluation.notes;
  return json_text(json);
}

std::string json_array(const std::vector<std::string>& objects) {
  std::string text = "[";
  for (const std::string& object : objects) text += (text.size() > 1 ? ",\n" : "\n") + object;
  return text + "\n]\n";
}

}  // namespace nlo::trainer
