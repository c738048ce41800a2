// SPDX-License-Identifier: MIT
// Conformal calibration: the likelihood gives the shape of sigma, runs that it has not seen give its size, for any
// distribution of the errors. |error| / sigma of 68 % of these is below factor_68, of 95 % below factor_95.
// Source: Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, Distribution-free predictive inference for regression, JASA
// 2018, with sigma for its local scale.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/error_head_parameters.h"
#include "trainer/learn/uncertainty/error_samples.h"

namespace nlo::trainer {

inline constexpr double kNormal95 = 1.959963984540054;  ///< 95 % of a normal distribution lie within this many sigmas

/// The smallest of `values` that at least the share `p` of the weight does not exceed; 0 < p <= 1. N >= 1 each.
double weighted_quantile(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double p);

/// sigma of each sample by a head, n_x x N, outside of the domain as inside.
Eigen::MatrixXd deviations_everywhere(const codegen::ErrorHead& head, const ErrorSamples& samples);

/// |error| / sigma by the head of the model that made the errors.
struct ErrorScores {
  Eigen::MatrixXd ratios;   ///< n_x x N
  Eigen::VectorXd weights;  ///< N, known_weights(): the error is unknown outside of the domain
};

ErrorScores error_scores(const codegen::ErrorHead& head, const ErrorSamples& samples);

/// Sets factor_68 and factor_95 of each state: 68 % of the errors are within the first on 68 % of the sets, 95 % within
/// the second on 95 % of them. Pooled, many easy logs would speak for a hard one. At least one set, none of them empty.
void calibrate(codegen::ErrorHead& head, const std::vector<ErrorScores>& sets);

}  // namespace nlo::trainer
