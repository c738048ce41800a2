// SPDX-License-Identifier: MIT
// Error head of a model (nlo/error_head.h in flight): a second output of T* from its last hidden layer h,
//   log sigma = W [h; h^2] + b,  limited to [log_min, log_max]
// 68 % of the errors of a state were within factor_68 sigma and 95 % within factor_95 sigma, on runs to which neither
// T* nor W and b were fitted. In flight, sigma is factor_68 sigma.
#pragma once

#include <nlo/estimate_with_error.h>

#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::codegen {

struct ErrorHead {
  Eigen::MatrixXd weights;               ///< W, n_x x 2 n_h
  Eigen::VectorXd bias;                  ///< b, n_x
  Eigen::VectorXd log_min, log_max;      ///< n_x, range in training; sigma in the unit of its state
  Eigen::VectorXd factor_68, factor_95;  ///< n_x, positive
};

/// The error head in flight, with log2 and with factor_68 folded in.
struct FoldedErrorHead {
  DenseLayer layer;                 ///< [h; h^2] -> log2 sigma in flight
  Eigen::VectorXd lowest, highest;  ///< n_x
  Eigen::VectorXd bound_95;         ///< n_x, factor_95 / factor_68
};

FoldedErrorHead fold(const ErrorHead& head);

/// Returns sigma in flight, n_x x N, from the hidden layer h, n_h x N; kUnknownSigma in columns where known is false.
Eigen::MatrixXd deviations(const ErrorHead& head, const Eigen::MatrixXd& hidden, const std::vector<bool>& known);

/// Returns [h; h^2].
Eigen::MatrixXd error_features(const Eigen::MatrixXd& hidden);

}  // namespace nlo::codegen
