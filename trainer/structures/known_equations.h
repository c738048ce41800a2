// SPDX-License-Identifier: MIT
// A plant's equations as an observer's prior steps them. An angle is its sine and cosine there, which do not wrap:
//   angle' = f   becomes   angle_sin' = angle_cos f,  angle_cos' = -angle_sin f
#pragma once

#include <string>
#include <vector>

#include "codegen/model/equations.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct KnownEquations {
  codegen::EquationTexts texts;
  std::vector<codegen::Channel> states;  ///< the estimated ones in their order, then the others in that of the plant
  std::vector<codegen::Channel> outputs, inputs;
  std::vector<bool> on_circle;  ///< one for each state: the sine or cosine of an angle
};

/// An angle that wraps and is not encoded as its sine and cosine, or not in radians.
bool has_unwrapped_angle(const PlantConfig& plant);

/// Makes the equations of a plant by expressions. `inputs`: the inputs that the observer reads, at least the plant's.
/// Without `reads_inputs` they are 0. sqrt(v) is written sqrt(max(v, 0)), since an estimate may be where the plant
/// cannot be.
KnownEquations known_equations(const PlantConfig& plant, bool reads_inputs, const std::vector<std::string>& inputs);

}  // namespace nlo::trainer
