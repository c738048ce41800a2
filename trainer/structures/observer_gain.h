// SPDX-License-Identifier: MIT
// The gain G of a Luenberger observer: given, placed or optimal. Each result makes A - G C Hurwitz, or there is none.
#pragma once

#include <Eigen/Core>

#include "trainer/config/experiment.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// G (n_x x n_y) such that A - G C has the given real eigenvalues (n_x, distinct for a plant of several outputs), by
/// Ackermann's formula on one combination of the outputs that sees every mode.
/// Throws codegen::Error when (A, C) is not observable.
Eigen::MatrixXd place_poles(const Eigen::MatrixXd& state_matrix, const Eigen::MatrixXd& output_matrix,
                            const Eigen::VectorXd& poles);

/// Stationary Kalman gain G = P C^T / r for process noise of intensity q on every state and measurement noise of
/// intensity r on every output; P solves A P + P A^T - P C^T C P / r + q = 0, from the stable invariant subspace of the
/// Hamiltonian matrix (Laub 1979). Throws codegen::Error when there is none.
Eigen::MatrixXd kalman_gain(const Eigen::MatrixXd& state_matrix, const Eigen::MatrixXd& output_matrix,
                            double process_noise, double measurement_noise);

/// A, C and G of [observer]: sizes checked against n_x and n_y, G designed if it is not given, A - G C checked.
/// Throws codegen::Error `[observer] gain ...` naming key, fault and mend.
LinearPart linear_part(const ObserverConfig& observer, int nx, int ny);

}  // namespace nlo::trainer
