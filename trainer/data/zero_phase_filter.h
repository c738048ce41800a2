// SPDX-License-Identifier: MIT
// Velocities without delay, for use as truth: a Butterworth low-pass run forward and backward over a whole log, then a
// central difference. It needs future samples, so an observer cannot do this; the logged velocities of rigs are causal
// and late.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// One second-order section, y_k = b0 x_k + b1 x_{k-1} + b2 x_{k-2} - a1 y_{k-1} - a2 y_{k-2}; of first order when
/// b2 = a2 = 0.
struct FilterSection {
  double b0, b1, b2, a1, a2;
};

/// Returns a Butterworth low-pass of `order` 1..8 by the bilinear transform, prewarped: |H| = 1 at DC and 1/sqrt(2) at
/// the cut-off. Throws codegen::Error for another order or a cut-off outside (0, sample_rate / 2).
std::vector<FilterSection> butterworth_lowpass(int order, double cutoff_hz, double sample_rate_hz);

/// Runs the sections forward, then backward: zero phase, |H|^2. The ends are extended by odd reflection over 3 (order +
/// 1) samples, and each pass starts in the steady state of its first sample, like scipy.signal.sosfiltfilt. Throws
/// codegen::Error if `x` is not longer than the extension.
Eigen::VectorXd filter_zero_phase(const std::vector<FilterSection>& sections, const Eigen::VectorXd& x);

/// Returns (x_{k+1} - x_{k-1}) / 2h inside, one-sided differences at the ends. Needs at least two samples.
Eigen::VectorXd central_difference(const Eigen::VectorXd& x, double h);

/// Returns values on straight lines between the samples (time increasing); beyond the ends the end values.
Eigen::VectorXd interpolate(const Eigen::VectorXd& time, const Eigen::VectorXd& x, const Eigen::VectorXd& at);

/// Returns the velocity of a logged, unwrapped position at its own, jittering time stamps: interpolated to a uniform
/// grid of about `sample_period_s`, filtered, differentiated, interpolated back.
Eigen::VectorXd zero_phase_velocity(const VelocityFilterConfig& config, const Eigen::VectorXd& time_s,
                                    const Eigen::VectorXd& position, double sample_period_s);

}  // namespace nlo::trainer
