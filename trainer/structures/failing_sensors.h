// SPDX-License-Identifier: MIT
// Sensors that may fail (nlo/sensor_failures.h), as [observer] declares them: for structures whose T* or latent system
// reads how stale an output is.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// may_fail and staleness_s.
std::vector<Key<ObserverConfig>> failing_sensor_keys();

/// Whether may_fail names any.
bool has_failing_sensors(const ObserverConfig& observer);

/// [observer] of another structure that has these keys: all defaults but them and the hold of inputs.
ObserverConfig plain_observer_of(std::string_view structure, const ObserverConfig& other);

/// Throws KeyError unless may_fail names outputs, each once, no angle, and leaves one to observe by.
void check_failing_sensors(const Experiment& experiment, const ChannelCounts& channels);

/// With the mean of each over the training data, where it fades to while it is missing.
codegen::SensorFailures failing_sensors(const Experiment& experiment, const Dataset& training);

}  // namespace nlo::trainer
