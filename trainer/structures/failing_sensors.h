// SPDX-License-Identifier: MIT
// Sensors that [observer] declares as may_fail (nlo/sensor_failures.h). Only structures whose T* or latent system reads
// the staleness of outputs can have them.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// Returns the keys may_fail and staleness_s.
std::vector<Key<ObserverConfig>> failing_sensor_keys();

/// Returns true if may_fail names an output.
bool has_failing_sensors(const ObserverConfig& observer);

/// Returns the [observer] of another structure that also has these keys. It keeps these keys and the hold of inputs;
/// all other keys have their defaults.
ObserverConfig plain_observer_of(std::string_view structure, const ObserverConfig& other);

/// Throws KeyError unless may_fail names each output at most once, names no angle, and leaves at least one output that
/// cannot fail.
void check_failing_sensors(const Experiment& experiment, const ChannelCounts& channels);

/// Returns the sensors that may fail. A missing output decays to its mean over the training data.
codegen::SensorFailures failing_sensors(const Experiment& experiment, const Dataset& training);

}  // namespace nlo::trainer
