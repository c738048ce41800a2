// SPDX-License-Identifier: MIT
// The filters of filter_table(), untuned, as estimators of a plant's channels: over a run that is there, with what they
// say of their own errors, and in the loop that [feedback] closes.
#pragma once

#include <string_view>

#include "trainer/compare/filter_table.h"
#include "trainer/evaluation/evaluate.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

/// Each knows the plant of `nominal` and the noise's nominal variance. Samples that do not arrive are stepped over.
/// Throws codegen::Error where there is no such filter, or it is not for the plant.
///   held_inputs     the u of a sample has acted since the sample before; else a ramp from there
///   with_intervals  of the normal distribution by its covariance, where it has one and the channels are
///                   the plant's own
EstimatorFactory table_filter(std::string_view name, const Experiment& nominal, const NoiseConfig& noise,
                              bool held_inputs, bool with_intervals = false);

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise);

}  // namespace nlo::trainer
