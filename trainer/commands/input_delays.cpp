// SPDX-License-Identifier: MIT
#include "trainer/commands/input_delays.h"

#include <algorithm>

#include "trainer/data/log_delays.h"

namespace nlo::trainer {

void record_input_delays(const Experiment& experiment, codegen::Model& model) {
  if (!experiment.log || model.nu() == 0) return;
  const std::string delays = delays_in_flight(*experiment.log, model.sample_period_s);
  if (delays.empty()) return;
  // Before the config, which is long: a reader of model.json meets it first.
  const auto config = std::find_if(model.provenance.begin(), model.provenance.end(),
                                   [](const auto& fact) { return fact.first == "config"; });
  model.provenance.insert(config, {"input_delay", "feed u as it was so many samples ago: " + delays});
}

}  // namespace nlo::trainer
