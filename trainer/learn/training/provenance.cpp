// SPDX-License-Identifier: MIT
#include "trainer/learn/training/provenance.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

#include "trainer/base/number_text.h"
#include "trainer/base/version.h"

namespace nlo::trainer {

namespace {

std::string without_steps(const std::string& source_text) {
  constexpr std::string_view kKey = "\nsteps = ";
  const auto begin = source_text.find(kKey);
  if (begin == std::string::npos) return source_text;
  const auto end = source_text.find('\n', begin + 1);
  return source_text.substr(0, begin) + (end == std::string::npos ? "" : source_text.substr(end));
}

}  // namespace

std::uint64_t data_fingerprint(const Dataset& dataset, std::uint64_t hash) {
  const auto add = [&hash](const auto& m) {
    hash = fingerprint(m.data(), static_cast<std::size_t>(m.size()) * sizeof(double), hash);
  };
  for (const Trajectory& trajectory : dataset.trajectories) {
    add(trajectory.time_s);
    add(trajectory.outputs);
    if (dataset.reads_inputs) add(trajectory.inputs);
    add(trajectory.states);
    add(trajectory.weight);
    if (trajectory.missing.size() != 0) add(trajectory.missing.cast<double>().eval());
  }
  return hash;
}

std::uint64_t training_data_hash(const Dataset& training, const Dataset& validation) {
  return data_fingerprint(validation, data_fingerprint(training, fingerprint(nullptr, 0)));
}

std::string hex_text(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::uint64_t run_fingerprint(const Experiment& experiment, std::uint64_t data_hash) {
  const std::string identity = without_steps(experiment.source_text) + '\n' + std::to_string(experiment.seed);
  return fingerprint(identity.data(), identity.size(), data_hash);
}

std::vector<std::pair<std::string, std::string>> run_facts(const Experiment& experiment, const Dataset& dataset,
                                                           std::uint64_t data_hash, const TrainingState& state,
                                                           double validation_rmse) {
  double time_s = 0.0;
  for (const Trajectory& trajectory : dataset.trajectories) {
    time_s += trajectory.time_s(trajectory.samples() - 1) - trajectory.time_s(0);
  }
  return {{"nlo", kVersion},
          {"seed", std::to_string(experiment.seed)},
          {"data",
           std::to_string(dataset.trajectories.size()) + " trajectories, " + shortest_text(std::round(time_s)) + " s"},
          {"data_hash", hex_text(data_hash)},
          {"steps", std::to_string(state.step)},
          {"validation_rmse", shortest_text(validation_rmse)}};
}

}  // namespace nlo::trainer
