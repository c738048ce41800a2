// SPDX-License-Identifier: MIT
// The error of an export's arithmetic: differences between the exported observer and the model's equations in double,
// over the flights that training recorded, each from a reset, and over synthetic tones where flights are few.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/replay_run.h"

namespace nlo::codegen {

/// |exported - exact| of each state (n_x), in its unit.
struct ExportError {
  Eigen::VectorXd max, rms;     ///< over the samples whose z lies in the domain
  Eigen::VectorXd quantile999;  ///< 99.9 % of them are within this
  Eigen::VectorXd max_outside;  ///< over the samples outside of the domain; 0 when there are none
  int samples = 0, outside = 0;
  int recorded = 0;  ///< number of `samples` from recorded flights; the others are from tones
};

/// The smallest of `values` that at least the share `p` of them do not exceed; 0 < p <= 1. 0 of none.
double quantile(std::vector<double> values, double p);

/// The exact side, run once for all formats of numbers. Tones are added to the flights until 10,000 samples lie in the
/// domain; some of full amplitude, with faults, are always there.
class ErrorReplay {
 public:
  /// `plain`: the model folded. Throws Error, with the mend, when fewer than 1,000 samples lie in the domain.
  ErrorReplay(const Model& model, const FoldedModel& plain);

  /// Error of the folded model `exported` in a scalar, with integers where `quantised` is given.
  ExportError error(const FoldedModel& exported, const QuantisedModel* quantised, ScalarType scalar) const;

 private:
  void add(ReplayInputs inputs);

  Model model_;
  Eigen::MatrixXd steady_gain_;          ///< S, n_z x n_y
  std::vector<ReplayInputs> runs_;       ///< each from a reset on
  std::vector<Eigen::MatrixXd> y_;       ///< n_y x N of each run: as the observer took them, angles turned back
  std::vector<Eigen::MatrixXd> turned_;  ///< n_y x N of each run: whole turns of angles that were taken back
  std::vector<Eigen::MatrixXd> x_hat_;   ///< n_x x N of each run
  std::vector<std::vector<bool>> in_domain_;
  int samples_ = 0, recorded_ = 0;  ///< in the domain
};

}  // namespace nlo::codegen
