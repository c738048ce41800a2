// SPDX-License-Identifier: MIT
// --noise and --disturbance of commands that bound an observer's error: |v| <= V and |w| <= W.
#pragma once

#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// V of |v_j| <= V. Without --noise: of the uniform noise that is as strong as the training's.
/// Throws codegen::Error, naming the option, where the noise has no bound or is not about zero.
double noise_limit(const std::string& text, const NoiseConfig& training);

/// W >= 0. Throws codegen::Error, naming the option.
double disturbance_limit(const std::string& text);

}  // namespace nlo::trainer
