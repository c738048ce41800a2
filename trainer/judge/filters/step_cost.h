// SPDX-License-Identifier: MIT
// The counted cost of a filter's step, the same on every machine.
#pragma once

#include <string_view>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Cost per sample: operations (additions, multiplications, divisions and comparisons), and calls of functions (sin,
/// tanh, a power, a square root).
struct StepCost {
  double operations = 0.0, functions = 0.0;

  StepCost operator+(const StepCost& other) const {
    return {operations + other.operations, functions + other.functions};
  }
  StepCost operator*(double times) const { return {times * operations, times * functions}; }
};

/// Returns the cost of one evaluation: an operator is one operation; x^2 and x^3 are one and two, another power is a
/// function.
StepCost cost_of_expression(std::string_view expression);

/// Cost of f and h of a plant, counted from its equations.
struct PlantCost {
  StepCost f, h;
};
PlantCost plant_cost(const PlantConfig& plant);

/// Returns the cost of a step of RK4 with n states.
StepCost rk4_cost(double n, const StepCost& f);

/// Returns the cost of SigmaPointFilter with n states and ny outputs, EKF or UKF, with `steps` of RK4 in a sample
/// period.
StepCost sigma_point_cost(double n, double ny, bool extended, const PlantCost& plant, double steps = 1.0);

/// Returns the cost of a FilterBank with `members` filters of cost `one`.
StepCost bank_cost(double members, double n, double ny, const StepCost& one);

/// Returns the cost of the Kalman filter with constant acceleration, for one quantity.
StepCost cost_of_constant_acceleration();

}  // namespace nlo::trainer
