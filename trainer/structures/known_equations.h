// SPDX-License-Identifier: MIT
// A plant's equations in the form that an observer's prior integrates. An angle is replaced by its sine and cosine,
// which do not wrap:
//   angle' = f   becomes   angle_sin' = angle_cos f,  angle_cos' = -angle_sin f
#pragma once

#include <string>
#include <vector>

#include "codegen/model/equations.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct KnownEquations {
  codegen::EquationTexts texts;
  std::vector<codegen::Channel> states;  ///< estimated states in their order, then the others in the plant's order
  std::vector<codegen::Channel> outputs, inputs;
  std::vector<bool> on_circle;  ///< one for each state: the sine or cosine of an angle
};

/// Returns true if the plant has an angle that wraps and is not encoded as sine and cosine, or is not in radians.
bool has_unwrapped_angle(const PlantConfig& plant);

/// Makes the equations of a plant that is given by expressions. `inputs`: the inputs that the observer reads, at least
/// those of the plant. Without `reads_inputs` they are 0. sqrt(v) becomes sqrt(max(v, 0)), because an estimate may have
/// values that the plant cannot have.
KnownEquations known_equations(const PlantConfig& plant, bool reads_inputs, const std::vector<std::string>& inputs);

}  // namespace nlo::trainer
