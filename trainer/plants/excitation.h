// SPDX-License-Identifier: MIT
// The input u(t) of a driven plant (24). It is known at all times, so a simulation evaluates it at the times of its
// Runge-Kutta stages instead of holding samples.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Returns u (n_u) at a time [s] since the start of a trajectory. Null: u = 0, and no inputs are recorded.
using Excitation = std::function<Eigen::VectorXd(double time_s)>;

/// Makes u(t) from one expression over t for each input of the plant, in their order: {"cos(12*t)"}; see
/// plant_expression.h. Returns null without expressions. Throws codegen::Error with the input, the expression and the
/// position in it, or the number of inputs of the plant. u(t) throws if an expression has no finite value. Two threads
/// must not share it.
Excitation parse_excitation(const Plant& plant, const std::vector<std::string>& expressions);

/// Pairs each input with its expression for readers: ("u", "cos(12*t)").
std::vector<std::pair<std::string, std::string>> name_expressions(const Plant& plant,
                                                                  const std::vector<std::string>& expressions);

}  // namespace nlo::trainer
