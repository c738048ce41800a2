// SPDX-License-Identifier: MIT
// Generates measurements that test an observer, for `replay`.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"

namespace nlo::codegen {

struct ReplayInputs {
  Eigen::VectorXd dt_s;     ///< N; 0: the sample period
  Eigen::MatrixXd outputs;  ///< n_y x N, as measured: angles wrapped, NaN if missing
  Eigen::MatrixXd inputs;   ///< n_u x N, within their range, or +-1 if no range is declared; NaN if missing
};

/// Sums of tones within the declared ranges, slow compared with the sample period. Angles that may turn do so two and a
/// half times. From the tenth sample on, some are missing or out of range, and once `stale_after` in a row are missing.
/// An output that T* reads only relatively is shifted by a few of its wraps W (flown_ranges.h) instead. turns_relative
/// moves it by 0.8 W. `amplitude` scales the tones of inputs, and those of outputs except turning angles. The tones are
/// centred in `ranges` (n_r x 2: low, high), or in the declared ranges if `ranges` is empty. With follows_equations,
/// outputs of a model with known equations are those of its plant, with some noise.
ReplayInputs replay_inputs(const Model& model, int stale_after, std::uint64_t seed, int samples, double amplitude = 1.0,
                           const Eigen::MatrixXd& ranges = {}, bool turns_relative = false,
                           bool follows_equations = false);

}  // namespace nlo::codegen
