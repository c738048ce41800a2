// SPDX-License-Identifier: MIT
// Bounds of an activation and of its slope over an interval, from which bounds of a network's Jacobian are made. They
// follow from the activation's row in codegen/model/activations.h and hold for the real function: rounding is included,
// with functions of the standard library as rounding.h assumes them.
#pragma once

#include <Eigen/Core>

#include "codegen/model/activations.h"

namespace nlo::trainer {

/// No slope of an activation, and no centre of a line, is larger.
inline constexpr double kSteepest = 2.0;

/// Smallest and largest slope.
struct SlopeRange {
  double low, high;
};

/// Over [low, high]; but for rounding exact for tanh and relu, within 1e-5 for silu.
SlopeRange slope_range(const codegen::ActivationRow& activation, double low, double high);

/// Slopes of neurons over intervals of their pre-activations x, v being one point of each:
///   slope(x) = centre + gradient (x - v) +- remainder,   slope(x) = centre +- range
struct SlopeLine {
  Eigen::VectorXd centre, gradient, remainder, range;
};
SlopeLine slope_line(const codegen::ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     const Eigen::VectorXd& v);

/// The activations themselves over such intervals: activation(x) = offset + gradient x +- remainder.
struct ActivationLine {
  Eigen::VectorXd offset, gradient, remainder;
};
ActivationLine activation_line(const codegen::ActivationRow& activation, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high);

/// Ranges of the activations themselves over [low, high].
void activated_range(const codegen::ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     Eigen::VectorXd& lowest, Eigen::VectorXd& highest);

}  // namespace nlo::trainer
