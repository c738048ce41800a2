// SPDX-License-Identifier: MIT
#include "trainer/experiments/observer_channels.h"

#include "trainer/data/log_schema.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

ChannelCounts observer_channels(const Experiment& experiment) {
  if (experiment.plant) {
    const auto plant = make_plant(*experiment.plant);
    const PlantChannels channels(*experiment.plant, *plant);
    const bool reads = experiment.moves_inputs() && structure_of(experiment.observer).reads_inputs();
    return {static_cast<int>(channels.states().size()),
            static_cast<int>(channels.outputs().size()),
            static_cast<int>(plant->nu()),
            reads ? static_cast<int>(plant->nu()) : 0,
            channels.outputs(),
            reads ? plant->inputs() : std::vector<Channel>{},
            channels.states()};
  }
  const LogSchema schema = resolve_columns(*experiment.log);
  const auto inputs = static_cast<int>(schema.input_channels.size());
  return {static_cast<int>(schema.state_channels.size()),
          static_cast<int>(schema.output_channels.size()),
          inputs,
          structure_of(experiment.observer).reads_inputs() ? inputs : 0,
          schema.output_channels,
          schema.input_channels,
          schema.state_channels};
}

bool uses_forward_map(const Experiment& experiment) {
  return structure_of(experiment.observer).flies_forward_map() || needs_forward_map(experiment.loss);
}

}  // namespace nlo::trainer
