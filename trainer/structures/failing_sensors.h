// SPDX-License-Identifier: MIT
// Sensors that may fail (nlo/sensor_failures.h), as [observer] declares them. They are for structures whose T* or
// latent system reads the staleness of outputs.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// Returns the keys may_fail and staleness_s.
std::vector<Key<ObserverConfig>> failing_sensor_keys();

/// Returns true if may_fail names an output.
bool has_failing_sensors(const ObserverConfig& observer);

/// Returns an [observer] of another structure that has these keys. It keeps them and the hold of inputs; everything
/// else is default.
ObserverConfig plain_observer_of(std::string_view structure, const ObserverConfig& other);

/// Throws KeyError unless may_fail names each output at most once, names no angle, and leaves at least one output that
/// cannot fail.
void check_failing_sensors(const Experiment& experiment, const ChannelCounts& channels);

/// Returns the sensors that may fail. A missing output fades to its mean over the training data.
codegen::SensorFailures failing_sensors(const Experiment& experiment, const Dataset& training);

}  // namespace nlo::trainer
