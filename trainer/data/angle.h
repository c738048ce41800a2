// SPDX-License-Identifier: MIT
// Angles in any unit: `wrap` is a full turn (2 pi for rad, 360 for degrees) and positive.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::trainer {

/// Two neighbouring channels that are the sine and the cosine of one angle.
struct EncodedAngle {
  Eigen::Index sine;  ///< channel of the sine; the channel of the cosine follows
  double wrap;        ///< full turn of the angle
};

/// Returns the angle difference wrapped into (-wrap/2, wrap/2].
double wrap_difference(double difference, double wrap);

/// Removes the jumps of an angle: whole turns are added to each sample so that it is within half a turn of the last
/// one. The first sample is not changed. Correct as long as the true angle moves less than half a turn between samples.
Eigen::VectorXd unwrap(const Eigen::VectorXd& angle, double wrap);

/// Returns the sine and the cosine of an angle, and the angle (in (-wrap/2, wrap/2]) of a point that need not be on the
/// unit circle.
Eigen::VectorXd sine_of(const Eigen::VectorXd& angle, double wrap);
Eigen::VectorXd cosine_of(const Eigen::VectorXd& angle, double wrap);
Eigen::VectorXd angle_of(const Eigen::VectorXd& sine, const Eigen::VectorXd& cosine, double wrap);

/// Converts channels for a regression: an angle becomes its sine and cosine, other channels stay. angles_decoded() is
/// the inverse.
Eigen::MatrixXd angles_encoded(const Eigen::MatrixXd& values, const std::vector<codegen::Channel>& channels);
Eigen::MatrixXd angles_decoded(const Eigen::MatrixXd& rows, const std::vector<codegen::Channel>& channels);

}  // namespace nlo::trainer
