// SPDX-License-Identifier: MIT
// A Kalman filter in the loop that [feedback] closes, beside an observer in the same loop.
#pragma once

#include <string_view>

#include "trainer/compare/filter_table.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

/// The filter of this name of filter_table(), untuned: it knows the nominal plant and the noise's nominal variance.
/// Throws codegen::Error where it is not for the plant.
LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise);

}  // namespace nlo::trainer
