// SPDX-License-Identifier: MIT
// A plant without inputs, dx/dt = f(x), y = h(x), over a box of its states: intervals that contain f, h and their
// derivatives, including rounding. Proofs of an observer's error use them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "codegen/model/shared_expressions.h"
#include "trainer/config/experiment.h"
#include "trainer/prove/interval_matrix.h"
#include "trainer/prove/jacobian_enclosure.h"
#include "trainer/prove/taylor_model.h"

namespace nlo::trainer {

/// A box of states, n_x.
using StateBox = InputBox;

/// f, and y = h(x) with its derivatives along the motion of the plant: L_f q = dq/dx f.
struct PlantRanges {
  static constexpr std::size_t kRates = 4;  ///< y, L_f y, L_f^2 y, L_f^3 y

  IntervalMatrix f, f_slopes;                          ///< n_x x 1; df/dx, n_x x n_x
  std::array<IntervalMatrix, kRates> rates;            ///< n_y x 1 each
  std::array<IntervalMatrix, kRates - 1> rate_slopes;  ///< d/dx of the first three rates, n_y x n_x each
};

class PlantEnclosure {
 public:
  /// Inputs are 0. Throws codegen::Error if an expression has no derivative (sqrt at 0, sign) or is too long.
  explicit PlantEnclosure(const PlantConfig& plant);

  Eigen::Index nx() const { return nx_; }
  Eigen::Index ny() const { return ny_; }

  /// Returns the ranges over the box. They are not finite where the equations have no value.
  PlantRanges over(const StateBox& box) const;

  /// Returns f, then y, L_f y and L_f^2 y of every output, as functions over the box.
  std::vector<TaylorModel> models_over(const StateBox& box) const;

 private:
  Eigen::Index nx_, ny_;
  std::vector<double> constants_;         ///< arguments after the states: inputs (all 0), then parameters
  codegen::SharedExpressions rows_;       ///< expressions of PlantRanges
  codegen::SharedExpressions functions_;  ///< f, y, L_f y and L_f^2 y
};

}  // namespace nlo::trainer
