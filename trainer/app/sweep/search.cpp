// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/draws.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

/// Changes the structure. Half of the draws keep the structure of the given experiment.
void vary_structure(Experiment& experiment, double sample_period_s, Draws& draws) {
  if (draws.below(2) == 0) return;
  std::vector<Experiment> others;
  for (const TrainableStructure* structure : structure_table()) {
    Experiment other = experiment;
    if (structure->name() != experiment.observer.structure && structure->adopt(other, sample_period_s))
      others.push_back(std::move(other));
  }
  // A structure with matrices of the plant must be kept: the user chose it for these, and no other structure has them.
  Experiment same = experiment;
  if (!structure_of(experiment.observer).adopt(same, sample_period_s) || others.empty()) return;
  experiment = others[draws.below(others.size())];
}

/// Returns [section] key -> value, one line each, as format_experiment() writes them.
std::map<std::string, std::string> values_of(const Experiment& experiment) {
  std::map<std::string, std::string> values;
  const std::string text = format_experiment(experiment);
  std::string section;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    if (line.starts_with('[')) {
      const std::size_t name = line.find_first_not_of('[');
      section = line.substr(name, line.find(']') - name) + ".";
    } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
      values[section + line.substr(0, equals)] = line.substr(equals + 3);
    }
  }
  return values;
}

}  // namespace

std::optional<Experiment> drawn_experiment(const Experiment& base, double sample_period_s, std::uint64_t index) {
  if (index == 0) return base;
  Experiment experiment = base;
  Draws draws(base.seed * 0x10001ULL + index);
  vary_structure(experiment, sample_period_s, draws);
  const TrainableStructure& structure = structure_of(experiment.observer);
  structure.vary(experiment, draws);
  if (structure.has_inverse_map()) vary_widths(experiment.inverse_map.hidden, draws);
  const double faster = draws.one_of({0.3, 0.6, 1.0, 1.0, 1.7, 3.0});
  TrainingConfig& training = experiment.training;
  training.learning_rate = rounded(faster * training.learning_rate);
  training.eigenvalue_learning_rate = rounded(faster * training.eigenvalue_learning_rate);
  try {
    Experiment checked = parse_experiment(format_experiment(experiment), "a draw");
    checked.threads = base.threads;
    return checked;
  } catch (const codegen::Error&) {
    return std::nullopt;
  }
}

Difference difference(const Experiment& base, const Experiment& other) {
  const auto before = values_of(base), after = values_of(other);
  Difference result;
  for (const auto& [key, value] : after) {
    const auto found = before.find(key);
    if ((found != before.end() && found->second == value) || key == "training.steps" ||
        key == "training.validate_every" || key.starts_with("log.") ||
        (found == before.end() && key.starts_with("dynamics.")))
      continue;
    result.full += fmt::format("{}{} = {}", result.full.empty() ? "" : ", ", key, value);
    // The title leaves out training keys that follow from the structure, which it names.
    if (key.starts_with("training.") && key != "training.learning_rate") continue;
    const std::string space = result.title.empty() ? "" : " ";
    if (key == "observer.structure")
      result.title = value.substr(1, value.size() - 2) + space + result.title;
    else
      result.title += fmt::format("{}{}={}", space, key.substr(key.rfind('.') + 1), value);
  }
  return result;
}

void set_steps(Experiment& experiment, int steps) {
  constexpr int kValidations = 20;
  TrainingConfig& training = experiment.training;
  if (training.steps == steps) return;
  training.steps = steps;
  training.validate_every = std::clamp(steps / kValidations, 1, training.validate_every);
  experiment.source_text = format_experiment(experiment);
}

std::vector<Rung> halving_rungs(std::size_t candidates, double seconds) {
  std::vector<Rung> rungs = {{candidates}};
  constexpr std::size_t kLast = 2;
  while (rungs.back().candidates > kLast)
    rungs.push_back({std::max(kLast, (rungs.back().candidates + kKeptPart / 2) / kKeptPart)});
  const double share =
      seconds / (static_cast<double>(rungs.size()) + 1.0 / static_cast<double>(rungs.back().candidates));
  for (Rung& rung : rungs) rung.seconds = share / static_cast<double>(rung.candidates);
  return rungs;
}

std::size_t candidates_for(double seconds, double setup_s) {
  constexpr std::size_t kFewest = 4, kMost = 64;
  // A shorter training does not predict the time of longer ones [s].
  const double shortest = std::max(2.0, 3.0 * setup_s);
  std::size_t candidates = kFewest;
  while (candidates < kMost && halving_rungs(candidates + 1, seconds).front().seconds >= shortest) ++candidates;
  return candidates;
}

double steps_within(const TrainingPace& pace, double seconds) {
  constexpr double kLeast = 0.25;
  return std::max(seconds - pace.setup_s, kLeast * seconds) * pace.steps_per_s;
}

double minutes_for(const TrainingPace& pace, double steps) {
  constexpr double kForTrainings = 0.8, kLongest = 1e5;
  const auto suffice = [&](double minutes) {
    const double seconds = 60.0 * kForTrainings * minutes;
    return steps_within(pace, halving_rungs(candidates_for(seconds, pace.setup_s), seconds).back().seconds) >= steps;
  };
  double minutes = 1.0;
  while (minutes < kLongest && !suffice(minutes)) minutes = std::ceil(1.05 * minutes);
  return minutes;
}

std::vector<std::size_t> best_of(const std::vector<std::optional<double>>& errors, std::size_t count) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i]) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return *errors[a] < *errors[b]; });
  order.resize(std::min(count, order.size()));
  return order;
}

}  // namespace nlo::trainer
