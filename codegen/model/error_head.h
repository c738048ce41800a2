// SPDX-License-Identifier: MIT
// How wrong an estimate is, as nlo/error_head.h flies it: a second output of T* from its last hidden layer h,
//   log sigma = W [h; h^2] + b,  held within [log_min, log_max]
// 68 % of a state's errors were within factor_68 sigma and 95 % within factor_95 sigma, over runs that neither T* nor
// W and b were fitted to. What flies as sigma is factor_68 sigma.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::codegen {

struct ErrorHead {
  Eigen::MatrixXd weights;               ///< W, n_x x 2 n_h
  Eigen::VectorXd bias;                  ///< b, n_x
  Eigen::VectorXd log_min, log_max;      ///< n_x, of what training has seen; sigma in the unit of its state
  Eigen::VectorXd factor_68, factor_95;  ///< n_x, positive
};

/// The same in powers of two, with factor_68 folded in.
struct FoldedErrorHead {
  DenseLayer layer;                 ///< [h; h^2] -> log2 of what flies as sigma
  Eigen::VectorXd lowest, highest;  ///< n_x
  Eigen::VectorXd bound_95;         ///< n_x, factor_95 / factor_68
};

FoldedErrorHead fold(const ErrorHead& head);

/// nlo::kUnknownSigma.
inline constexpr double kUnknownSigma = 0x1p100;

/// sigma as it flies, n_x x N, from the hidden layer h, n_h x N; kUnknownSigma outside of the domain (not `known`).
Eigen::MatrixXd deviations(const ErrorHead& head, const Eigen::MatrixXd& hidden, const std::vector<bool>& known);

/// [h; h^2].
Eigen::MatrixXd error_features(const Eigen::MatrixXd& hidden);

}  // namespace nlo::codegen
