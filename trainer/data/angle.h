// SPDX-License-Identifier: MIT
// Angles in any unit: `wrap` is a full turn (2 pi for rad, 360 for degrees) and positive.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::trainer {

/// Two neighbouring channels that are the sine and the cosine of one angle.
struct EncodedAngle {
  Eigen::Index sine;  ///< channel of the sine; the cosine's is the next
  double wrap;        ///< full turn of the angle
};

/// Returns the angle difference wrapped into (-wrap/2, wrap/2].
double wrap_difference(double difference, double wrap);

/// Takes the jumps out of an angle: each sample moves by whole turns to within half a turn of the one before. The
/// first sample stays. Right as long as the true angle moves less than half a turn between samples.
Eigen::VectorXd unwrap(const Eigen::VectorXd& angle, double wrap);

/// Sine and cosine of an angle, and the angle (in (-wrap/2, wrap/2]) of a point that need not lie on the unit circle.
Eigen::VectorXd sine_of(const Eigen::VectorXd& angle, double wrap);
Eigen::VectorXd cosine_of(const Eigen::VectorXd& angle, double wrap);
Eigen::VectorXd angle_of(const Eigen::VectorXd& sine, const Eigen::VectorXd& cosine, double wrap);

/// Channels as a regression takes them: an angle is its sine and its cosine, all else as it is. And back.
Eigen::MatrixXd angles_encoded(const Eigen::MatrixXd& values, const std::vector<codegen::Channel>& channels);
Eigen::MatrixXd angles_decoded(const Eigen::MatrixXd& rows, const std::vector<codegen::Channel>& channels);

}  // namespace nlo::trainer
