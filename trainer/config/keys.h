// SPDX-License-Identifier: MIT
// The keys of an experiment file, each in one line of keys.cpp: reading, writing, suggestions and help come from there.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/config/toml.h"

namespace nlo::trainer {

template <class Section>
struct Key {
  std::string name;
  std::string type;     ///< in words, with the range
  std::string meaning;  ///< with the unit
  std::function<void(Section&, const Toml&, const std::string& where)> read;
  std::function<std::string(const Section&)> show;  ///< as a TOML value
};

/// Defined for Experiment (the keys above all sections), PlantConfig, SimulationConfig, LogConfig, ColumnConfig,
/// VelocityFilterConfig, ObserverConfig, InverseMapConfig and TrainingConfig.
template <class Section>
const std::vector<Key<Section>>& keys();

/// "[observer]", "[[log.columns]]"; "the experiment" for the keys above all sections.
template <class Section>
std::string_view section_title();

}  // namespace nlo::trainer
