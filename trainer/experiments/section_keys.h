// SPDX-License-Identifier: MIT
// The keys of every section, with the names that plants, structures, optimisers and networks bring.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/config/keys.h"

namespace nlo::trainer {

/// Defined for Experiment (the keys above all sections) and each of its sections.
template <class Section>
const std::vector<Key<Section>>& keys();

/// "[observer]", "[[log.columns]]"; "the experiment" for the keys above all sections.
template <class Section>
std::string_view section_title();

/// Calls visit(Section()) for each section, in the order that help lists them. Parentheses: GCC 12 fails on
/// LossConfig{} in a template.
template <class Visit>
void for_each_section(const Visit& visit) {
  visit(Experiment());
  visit(PlantConfig());
  visit(SimulationConfig());
  visit(ExcitationConfig());
  visit(FeedbackConfig());
  visit(LogConfig());
  visit(VelocityFilterConfig());
  visit(ColumnConfig());
  visit(ObserverConfig());
  visit(DynamicsConfig());
  visit(InverseMapConfig());
  visit(ForwardMapConfig());
  visit(LossConfig());
  visit(TrainingConfig());
  visit(ValidationConfig());
  visit(EvaluationConfig());
}

}  // namespace nlo::trainer
