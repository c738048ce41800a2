// SPDX-License-Identifier: MIT
// Measurements that test an observer, for `replay`.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"

namespace nlo::codegen {

struct ReplayInputs {
  Eigen::VectorXd dt_s;     ///< N; 0: the sample period
  Eigen::MatrixXd outputs;  ///< n_y x N, as measured: angles wrapped, NaN where missed
  Eigen::MatrixXd inputs;   ///< n_u x N, within their range, or +-1 where none is declared; NaN where missed
};

/// Sums of tones inside the declared ranges, slow against the sample period; angles that may turn do so two times and
/// a half. From the tenth sample on, some are missed or out of range, and `stale_after` are missed in a row. An output
/// that T* knows only relatively (flown_ranges.h) is given some W on instead, and with `turns_relative` it moves on by
/// 0.8 W. `amplitude` scales the tones of inputs, and those of outputs that are no turning angles. The tones are
/// about the middle of `ranges` (n_r x 2: low, high); where that is empty, about the middle of the declared ranges.
ReplayInputs replay_inputs(const Model& model, int stale_after, std::uint64_t seed, int samples, double amplitude = 1.0,
                           const Eigen::MatrixXd& ranges = {}, bool turns_relative = false);

}  // namespace nlo::codegen
