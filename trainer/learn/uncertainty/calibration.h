// SPDX-License-Identifier: MIT
// Conformal calibration for any distribution of the errors. The likelihood determines the shape of sigma. Its size is
// determined from runs that the likelihood did not use: 68 % of them have |error| / sigma below factor_68, and 95 %
// below factor_95.
// Source: Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, Distribution-free predictive inference for regression, JASA
// 2018, with sigma as the local scale.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/error_head_parameters.h"
#include "trainer/learn/uncertainty/error_samples.h"

namespace nlo::trainer {

inline constexpr double kNormal95 = 1.959963984540054;  ///< 95 % of a normal distribution lie within this many sigmas

/// Returns the p-quantile: the smallest of `values` such that values up to it have at least the share `p` of the
/// weight; 0 < p <= 1. Needs at least one value.
double weighted_quantile(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double p);

/// Returns sigma of each sample by a head, n_x x N, computed outside of the domain in the same way as inside.
Eigen::MatrixXd deviations_everywhere(const codegen::ErrorHead& head, const ErrorSamples& samples);

/// Ratios |error| / sigma, with sigma from the error head of the model that made the errors.
struct ErrorScores {
  Eigen::MatrixXd ratios;   ///< n_x x N
  Eigen::VectorXd weights;  ///< N, by known_weights()
};

ErrorScores error_scores(const codegen::ErrorHead& head, const ErrorSamples& samples);

/// Sets factor_68 and factor_95 of each state: on 68 % of the sets, 68 % of the errors are within the first; on 95 % of
/// the sets, 95 % are within the second. If all errors were pooled, many easy logs would hide a hard one. Needs at
/// least one set and no empty set.
void calibrate(codegen::ErrorHead& head, const std::vector<ErrorScores>& sets);

}  // namespace nlo::trainer
