// SPDX-License-Identifier: MIT
// Activations, their slopes, and what is known of both over an interval: what bounds of a network's Jacobian are made
// of. By the standard library, as training differentiates; names as in codegen/model.h.
#pragma once

#include <Eigen/Core>
#include <string>

namespace nlo::trainer {

double activated(const std::string& activation, double v);
double activation_slope(const std::string& activation, double v);  ///< relu at 0: 0

/// Smallest and largest slope.
struct SlopeRange {
  double low, high;
};

/// Over [low, high]; exact for tanh and relu, within 1e-5 for silu.
SlopeRange slope_range(const std::string& activation, double low, double high);

/// Slopes of neurons over intervals of their pre-activations x, v being one point of each:
///   slope(x) = centre + gradient (x - v) +- remainder,   slope(x) = centre +- range
struct SlopeLine {
  Eigen::VectorXd centre, gradient, remainder, range;
};
SlopeLine slope_line(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     const Eigen::VectorXd& v);

/// The activations themselves over such intervals: activation(x) = offset + gradient x +- remainder.
struct ActivationLine {
  Eigen::VectorXd offset, gradient, remainder;
};
ActivationLine activation_line(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

/// Ranges of the activations themselves over [low, high].
void activated_range(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     Eigen::VectorXd& lowest, Eigen::VectorXd& highest);

}  // namespace nlo::trainer
