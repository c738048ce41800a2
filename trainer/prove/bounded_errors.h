// SPDX-License-Identifier: MIT
// The options --noise and --disturbance of commands that bound an observer's error: |v| <= V and |w| <= W.
#pragma once

#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns V of |v_j| <= V. Without --noise, V belongs to uniform noise with the standard deviation of the training
/// noise. Throws codegen::Error with the name of the option if the noise has no bound or its mean is not 0.
double noise_limit(const std::string& text, const NoiseConfig& training);

/// Returns W >= 0. Throws codegen::Error with the name of the option.
double disturbance_limit(const std::string& text);

}  // namespace nlo::trainer
