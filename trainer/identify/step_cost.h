// SPDX-License-Identifier: MIT
// What one step of a filter costs, counted: the same on every machine.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "trainer/config/identification.h"

namespace nlo::trainer {

/// Per sample: additions, multiplications, divisions and comparisons; and calls of functions (sin, tanh, a power, a
/// square root).
struct StepCost {
  double operations = 0.0, functions = 0.0;

  StepCost operator+(const StepCost& other) const {
    return {operations + other.operations, functions + other.functions};
  }
  StepCost operator*(double times) const { return {times * operations, times * functions}; }
};

/// Of one evaluation as it is written: an operator is one operation; x^2 and x^3 are one and two, another power is a
/// function.
StepCost cost_of_expression(std::string_view expression);

/// Of ekf_estimator: f and h at 2 n_x + 1 points, by RK4, and the Joseph form. `period_s`: the nominal one.
StepCost cost_of_ekf(const Identification& identification, double period_s);

/// Of ukf_estimator: the same points, two Cholesky factors, and the means.
StepCost cost_of_ukf(const Identification& identification, double period_s);

/// Of the Kalman filter with constant acceleration, for one quantity.
StepCost cost_of_constant_acceleration();

}  // namespace nlo::trainer
