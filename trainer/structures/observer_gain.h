// SPDX-License-Identifier: MIT
// The gain G of a Luenberger observer: given, placed or optimal. A - G C of every result is Hurwitz; otherwise there is
// an error.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace nlo::trainer {

/// Keys of [observer] for a Luenberger observer (15): A, C and B, row by row, and the gain G. G is given, or designed
/// from the eigenvalues of A - G C, or from the intensities of the noise.
struct LuenbergerConfig {
  std::vector<std::vector<double>> state_matrix = {}, output_matrix = {}, gain = {};
  std::vector<std::vector<double>> input_matrix = {};
  std::vector<double> gain_poles = {};  ///< real eigenvalues that A - G C must have, n_x
  std::vector<double> gain_noise = {};  ///< intensities of process and measurement noise: the stationary Kalman gain
};

/// The known part of (15): A n_x x n_x, C n_y x n_x, and the gain G n_x x n_y that makes A - G C Hurwitz.
struct LinearPart {
  Eigen::MatrixXd state_matrix, output_matrix, gain;
  Eigen::MatrixXd input_matrix;  ///< B, n_x x n_u; n_x x 0 if there are no known inputs

  /// Returns [G, B], which read [y; u].
  Eigen::MatrixXd reading_gain() const {
    Eigen::MatrixXd both(gain.rows(), gain.cols() + input_matrix.cols());
    both << gain, input_matrix;
    return both;
  }
};

/// Returns G (n_x x n_y) for which A - G C has the given real eigenvalues (n_x; distinct if there are several outputs),
/// by Ackermann's formula on one combination of the outputs that contains every mode. Throws KeyError if (A, C) is not
/// observable.
Eigen::MatrixXd place_poles(const Eigen::MatrixXd& state_matrix, const Eigen::MatrixXd& output_matrix,
                            const Eigen::VectorXd& poles);

/// Returns the stationary Kalman gain G = P C^T / r for process noise of intensity q on every state and measurement
/// noise of intensity r on every output. P solves A P + P A^T - P C^T C P / r + q = 0 and is computed from the stable
/// invariant subspace of the Hamiltonian matrix (Laub 1979). Throws KeyError if there is none.
Eigen::MatrixXd kalman_gain(const Eigen::MatrixXd& state_matrix, const Eigen::MatrixXd& output_matrix,
                            double process_noise, double measurement_noise);

/// Returns A, C, B and G: checks their sizes against n_x, n_y and n_u, designs G if it is not given, and checks A - G
/// C. Throws KeyError `[observer] gain ...` with the key, the fault and the remedy.
LinearPart linear_part(const LuenbergerConfig& config, int nx, int ny, int nu = 0);

}  // namespace nlo::trainer
