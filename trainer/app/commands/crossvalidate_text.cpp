// SPDX-License-Identifier: MIT
#include "trainer/app/commands/crossvalidate_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

struct Alternative {
  const char *estimator, *heading;
};
constexpr Alternative kAlternatives[] = {
    {"sensor", "sensor"}, {"ridge", "ridge"}, {"static_ridge", "products"}, {"constant", "constant"}};

struct OverLogs {
  double mean = 0.0, deviation = 0.0, worst = 0.0;
};

OverLogs over_logs(const std::vector<double>& values) {
  OverLogs all;
  for (const double value : values) {
    all.mean += value / static_cast<double>(values.size());
    all.worst = std::max(value, all.worst);
  }
  all.deviation = deviation_of(values).value_or(0.0);
  return all;
}

/// Returns the RMSE; NaN if the estimator does not apply.
double rmse(const FoldOutcome& outcome, const char* estimator, std::size_t state) {
  const auto found = outcome.errors.find(estimator);
  return found == outcome.errors.end() ? std::nan("") : found->second[state].rmse.front();
}

}  // namespace

std::string fold_table(const std::vector<FoldOutcome>& outcomes, const std::vector<LogGroup>& folds, int seeds) {
  std::string text;
  const std::vector<StateError>& states = outcomes.front().errors.at("observer");
  for (std::size_t i = 0; i < states.size(); ++i) {
    std::vector<std::string> headings = {"RMSE of " + with_unit(states[i].name, states[i].unit) + ", left out", "logs",
                                         seeds > 1 ? "observer ± over seeds" : "observer"};
    for (const Alternative& other : kAlternatives) headings.emplace_back(other.heading);
    Table table{std::move(headings)};
    std::vector<double> all;
    std::vector<std::vector<double>> others(std::size(kAlternatives));
    for (const LogGroup& fold : folds) {
      std::vector<double> own;
      const FoldOutcome* last = nullptr;
      for (const FoldOutcome& outcome : outcomes)
        if (outcome.fold == fold.name) {
          own.push_back(rmse(outcome, "observer", i));
          last = &outcome;
        }
      all.push_back(over_logs(own).mean);
      std::vector<std::string> row = {fold.name, std::to_string(fold.files.size()),
                                      to_text(Spread{all.back(), deviation_of(own)})};
      for (std::size_t a = 0; a < others.size(); ++a) {
        others[a].push_back(rmse(*last, kAlternatives[a].estimator, i));
        row.push_back(significant(others[a].back()));
      }
      table.add_row(std::move(row));
    }
    table.add_rule();
    const auto row = [&](const std::string& name, double OverLogs::*what) {
      std::vector<std::string> cells = {name, "", significant(over_logs(all).*what)};
      for (const std::vector<double>& each : others) cells.push_back(significant(over_logs(each).*what));
      table.add_row(std::move(cells));
    };
    row("mean", &OverLogs::mean);
    row("deviation over folds", &OverLogs::deviation);
    row("worst", &OverLogs::worst);
    text += (i == 0 ? "" : "\n") + table.to_text(2);
  }
  return text;
}

std::string curve_table(const std::vector<FoldOutcome>& outcomes, const std::vector<int>& sizes) {
  std::vector<std::string> headings = {"training logs"};
  const std::vector<StateError>& states = outcomes.front().errors.at("observer");
  for (const StateError& state : states) {
    headings.push_back(with_unit(state.name, state.unit));
    headings.push_back("ridge");
  }
  Table table{std::move(headings)};
  for (const int size : sizes) {
    std::vector<std::string> row = {std::to_string(size)};
    for (std::size_t i = 0; i < states.size(); ++i) {
      std::vector<double> own, ridge;
      for (const FoldOutcome& outcome : outcomes)
        if (outcome.logs == size) {
          own.push_back(rmse(outcome, "observer", i));
          ridge.push_back(rmse(outcome, "ridge", i));
        }
      row.push_back(significant(over_logs(own).mean));
      row.push_back(significant(over_logs(ridge).mean));
    }
    table.add_row(std::move(row));
  }
  return table.to_text(2);
}

std::string crossvalidation_json(const std::vector<FoldOutcome>& outcomes) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const FoldOutcome& outcome : outcomes) {
    nlohmann::ordered_json entry = {
        {"left_out", outcome.fold}, {"training_logs", outcome.logs}, {"seed", outcome.seed}};
    const std::vector<StateError>& states = outcome.errors.at("observer");
    for (std::size_t i = 0; i < states.size(); ++i) {
      nlohmann::ordered_json& of_state = entry["rmse"][states[i].name];
      of_state["observer"] = rmse(outcome, "observer", i);
      for (const Alternative& other : kAlternatives)
        if (const double error = rmse(outcome, other.estimator, i); std::isfinite(error))
          of_state[other.estimator] = error;
    }
    array.push_back(std::move(entry));
  }
  return array.dump(2) + "\n";
}

}  // namespace nlo::trainer
