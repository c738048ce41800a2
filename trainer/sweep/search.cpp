// SPDX-License-Identifier: MIT
#include "trainer/sweep/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/draws.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {
namespace {

/// Every other draw keeps the structure that was chosen by hand.
void vary_structure(Experiment& experiment, double sample_period_s, Draws& draws) {
  if (draws.below(2) == 0) return;
  std::vector<Experiment> others;
  for (const TrainableStructure* structure : structure_table()) {
    Experiment other = experiment;
    if (structure->name() != experiment.observer.structure && structure->adopt(other, sample_period_s))
      others.push_back(std::move(other));
  }
  // One that wants matrices of its plant was chosen for them, and another one cannot stand in for it.
  Experiment same = experiment;
  if (!structure_of(experiment.observer).adopt(same, sample_period_s) || others.empty()) return;
  experiment = others[draws.below(others.size())];
}

/// [section] key -> value, one line each, as format_experiment() writes them.
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
    // What a structure brings along is known by its name.
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

}  // namespace nlo::trainer
