// SPDX-License-Identifier: MIT
// Bounds an activation and its slope over an interval. The bounds of a network's Jacobian use these. They follow from
// the activation's row in codegen/model/activations.h and hold for the real function: they include rounding errors,
// with the accuracy of the standard library's functions that rounding.h assumes.
#pragma once

#include <Eigen/Core>

#include "codegen/model/activations.h"

namespace nlo::trainer {

/// Upper bound of the slopes of all activations, and of the centres of all lines.
inline constexpr double kSteepest = 2.0;

/// The smallest and the largest slope.
struct SlopeRange {
  double low, high;
};

/// Returns the slopes over [low, high]. Except for rounding, they are exact for tanh and relu, and within 1e-5 for
/// silu.
SlopeRange slope_range(const codegen::ActivationRow& activation, double low, double high);

/// Slopes of neurons over intervals of their pre-activations x, where v is one point of each interval:
///   slope(x) = centre + gradient (x - v) +- remainder,   slope(x) = centre +- range
struct SlopeLine {
  Eigen::VectorXd centre, gradient, remainder, range;
};
SlopeLine slope_line(const codegen::ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     const Eigen::VectorXd& v);

/// The activations over intervals of their pre-activations x: activation(x) = offset + gradient x +- remainder.
struct ActivationLine {
  Eigen::VectorXd offset, gradient, remainder;
};
ActivationLine activation_line(const codegen::ActivationRow& activation, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high);

/// Writes the ranges of the activations over [low, high].
void activated_range(const codegen::ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     Eigen::VectorXd& lowest, Eigen::VectorXd& highest);

}  // namespace nlo::trainer
