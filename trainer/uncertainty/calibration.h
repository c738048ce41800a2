// SPDX-License-Identifier: MIT
// Conformal calibration: the likelihood gives the shape of sigma, runs that it has not seen give its size, whatever the
// errors' distribution is. |error| / sigma of 68 % of these is below factor_68, of 95 % below factor_95.
// Source: Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, Distribution-free predictive inference for regression, JASA
// 2018, with sigma for its local scale.
#pragma once

#include <Eigen/Core>

#include "codegen/model/error_head.h"
#include "trainer/uncertainty/error_samples.h"

namespace nlo::trainer {

inline constexpr double kNormal95 = 1.959963984540054;  ///< 95 % of a normal distribution lie within this many sigmas

/// The smallest of `values` that at least the share `p` of the weight does not exceed; 0 < p <= 1. N >= 1 each.
double weighted_quantile(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double p);

/// Sets factor_68 and factor_95 of each state.
void calibrate(codegen::ErrorHead& head, const ErrorSamples& samples);

}  // namespace nlo::trainer
