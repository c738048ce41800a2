// SPDX-License-Identifier: MIT
#include "trainer/structures/structure_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "codegen/base/error.h"
#include "trainer/config/keys.h"
#include "trainer/data/transient.h"

namespace nlo::trainer {

// Each structure is defined in the file of its name.
const TrainableStructure& kkl_structure();
const TrainableStructure& driven_kkl_structure();
const TrainableStructure& luenberger_structure();
const TrainableStructure& general_structure();
const TrainableStructure& gated_structure();
const TrainableStructure& carried_structure();
const TrainableStructure& prior_structure();

std::vector<Key<ObserverConfig>> TrainableStructure::own_keys() const {
  return {};
}

std::span<const TrainableStructure* const> structure_table() {
  static const std::array kTable{&kkl_structure(),     &driven_kkl_structure(), &luenberger_structure(),
                                 &general_structure(), &gated_structure(),      &carried_structure(),
                                 &prior_structure()};
  return kTable;
}

std::vector<std::string> structure_names() {
  std::vector<std::string> names;
  for (const TrainableStructure* structure : structure_table()) names.emplace_back(structure->name());
  return names;
}

const TrainableStructure& structure_of(const ObserverConfig& observer) {
  for (const TrainableStructure* structure : structure_table())
    if (structure->name() == observer.structure) return *structure;
  throw codegen::Error(
      fmt::format("unknown structure \"{}\"; there are: {}", observer.structure, fmt::join(structure_names(), ", ")));
}

EvaluationWindows windows_of(const Experiment& experiment, double horizon_s) {
  const ObserverConfig& observer = experiment.observer;
  const double rate = structure_of(observer).has_eigenvalues() ? decay_rate(observer) : 0.0;
  return evaluation_windows(experiment.evaluation, rate, horizon_s);
}

}  // namespace nlo::trainer
