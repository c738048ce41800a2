// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/search_record.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::ordered_json;

template <class Number>
Number number_in(const Json& json, const char* key, Number least, Number most) {
  const Json& value = json.at(key);
  if (!value.is_number()) throw codegen::Error(fmt::format("{} is not a number", key));
  const double number = value.get<double>();
  if (!(number >= static_cast<double>(least) && number <= static_cast<double>(most)))
    throw codegen::Error(fmt::format("{} is {}", key, number));
  return value.get<Number>();
}

Candidate candidate_from(const Json& json) {
  constexpr Eigen::Index kMost = std::numeric_limits<std::int32_t>::max();
  Candidate candidate;
  candidate.experiment = json.at("experiment").get<std::string>();
  candidate.difference = json.at("difference").get<std::string>();
  candidate.title = json.at("title").get<std::string>();
  candidate.cost = {number_in<Eigen::Index>(json, "multiply_adds", 0, kMost),
                    number_in<Eigen::Index>(json, "flash_bytes", 0, kMost)};
  candidate.setup_s = number_in(json, "setup_s", 0.0, 1e9);
  candidate.steps_per_s = number_in(json, "steps_per_s", 0.0, 1e9);
  return candidate;
}

Trial trial_from(const Json& json, std::size_t candidates) {
  Trial trial;
  if (candidates == 0) throw codegen::Error("a trial of no candidate");
  trial.candidate = number_in<std::size_t>(json, "candidate", 0, candidates - 1);
  trial.steps = number_in(json, "steps", 1, 100'000'000);
  trial.done = json.at("done").get<bool>();
  if (const Json& error = json.at("error"); !error.is_null())
    trial.error = number_in(json, "error", 0.0, std::numeric_limits<double>::max());
  return trial;
}

}  // namespace

const Trial* SearchRecord::last_of(std::size_t candidate) const {
  const Trial* last = nullptr;
  for (const std::vector<Trial>& rung : rungs)
    for (const Trial& trial : rung)
      if (trial.candidate == candidate && trial.done) last = &trial;
  return last;
}

const Trial& SearchRecord::chosen() const {
  constexpr double kWithinSeeds = 0.98;
  const Trial* chosen = nullptr;
  for (const Trial& trial : rungs.back()) {
    if (!trial.error) continue;
    const bool over_by_hand = chosen != nullptr && by_hand_s > 0.0 && chosen->candidate == 0;
    if (chosen == nullptr || *trial.error < (over_by_hand ? kWithinSeeds : 1.0) * *chosen->error) chosen = &trial;
  }
  if (chosen == nullptr) throw codegen::Error("every training of the last rung diverged; give a lower learning_rate");
  return *chosen;
}

std::string to_json(const SearchRecord& record) {
  Json json = {{"identity", record.identity},
               {"seconds", record.seconds},
               {"by_hand_s", record.by_hand_s},
               {"candidates", Json::array()},
               {"rungs", Json::array()}};
  for (const Candidate& candidate : record.candidates)
    json["candidates"].push_back({{"experiment", candidate.experiment},
                                  {"difference", candidate.difference},
                                  {"title", candidate.title},
                                  {"multiply_adds", candidate.cost.multiply_adds},
                                  {"flash_bytes", candidate.cost.flash_bytes},
                                  {"setup_s", candidate.setup_s},
                                  {"steps_per_s", candidate.steps_per_s}});
  for (const std::vector<Trial>& rung : record.rungs) {
    Json trials = Json::array();
    for (const Trial& trial : rung)
      trials.push_back({{"candidate", trial.candidate},
                        {"steps", trial.steps},
                        {"done", trial.done},
                        {"error", trial.error ? Json(*trial.error) : Json(nullptr)}});
    json["rungs"].push_back(std::move(trials));
  }
  return json.dump(1) + "\n";
}

SearchRecord search_record_from_json(const std::string& text, const std::string& place) {
  try {
    const Json json = Json::parse(text);
    SearchRecord record;
    record.identity = json.at("identity").get<std::uint64_t>();
    record.seconds = number_in(json, "seconds", 0.0, 1e9);
    record.by_hand_s = number_in(json, "by_hand_s", 0.0, 1e9);
    for (const Json& candidate : json.at("candidates")) record.candidates.push_back(candidate_from(candidate));
    for (const Json& rung : json.at("rungs")) {
      std::vector<Trial>& trials = record.rungs.emplace_back();
      for (const Json& trial : rung) trials.push_back(trial_from(trial, record.candidates.size()));
      if (trials.empty()) throw codegen::Error("a rung without trials");
    }
    return record;
  } catch (const std::exception& error) {
    throw codegen::Error(fmt::format("{}: is not a record of a search ({}); remove it, and the search starts again",
                                     place, error.what()));
  }
}

}  // namespace nlo::trainer
