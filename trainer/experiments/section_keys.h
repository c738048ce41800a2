// SPDX-License-Identifier: MIT
// The keys of every section, including those of plants, structures, optimisers and networks.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/config/keys.h"

namespace nlo::trainer {

/// Defined for each section, and for Experiment, which stands for the keys above all sections.
template <class Section>
const std::vector<Key<Section>>& keys();

/// Returns "[observer]", "[[log.columns]]", or "the experiment" for the keys above all sections.
template <class Section>
std::string_view section_title();

/// Calls visit(Section()) for each section, in the order of the help. Parentheses are necessary, because GCC 12 fails
/// on LossConfig{} in a template.
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
