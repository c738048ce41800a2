// SPDX-License-Identifier: MIT
// The error of an export's arithmetic: differences between the exported observer and the model's equations in double.
// It is measured over the flights that training recorded, each from a reset, and over synthetic tones if there are few
// flights.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/replay_run.h"

namespace nlo::codegen {

/// |exported - exact| of each state (n_x), in its unit.
struct ExportError {
  Eigen::VectorXd max, rms;     ///< over the samples whose z lies in the domain
  Eigen::VectorXd quantile999;  ///< 99.9 % of these samples are within this
  Eigen::VectorXd max_outside;  ///< over the samples outside of the domain; 0 when there are none
  int samples = 0, outside = 0;
  int recorded = 0;  ///< number of `samples` from recorded flights; the others are from tones
};

/// Returns the smallest of `values` which at least the share `p` of them do not exceed; 0 < p <= 1. Returns 0 if there
/// are none.
double quantile(std::vector<double> values, double p);

/// Runs the exact side once for all number formats. If fewer than 10,000 samples of the flights are in the domain,
/// tones are added. A few tones with full amplitude and faults are always included.
class ErrorReplay {
 public:
  /// `plain`: the folded model. Throws Error with the remedy if fewer than 1,000 samples are in the domain.
  ErrorReplay(const Model& model, const FoldedModel& plain);

  /// Returns the error of the folded model `exported` in a scalar, with integers if `quantised` is given.
  ExportError error(const FoldedModel& exported, const QuantisedModel* quantised, ScalarType scalar) const;

 private:
  void add(ReplayInputs inputs);

  Model model_;
  Eigen::MatrixXd steady_gain_;     ///< S, n_z x n_y
  std::vector<ReplayInputs> runs_;  ///< each from a reset
  std::vector<Eigen::MatrixXd> y_;  ///< n_y x N of each run, as the observer used them: clamped, angles turned back
  std::vector<Eigen::MatrixXd> turned_;  ///< n_y x N of each run: whole turns that were subtracted from angles
  std::vector<Eigen::MatrixXd> x_hat_;   ///< n_x x N of each run
  std::vector<std::vector<bool>> in_domain_;
  int samples_ = 0, recorded_ = 0;  ///< in the domain
};

}  // namespace nlo::codegen
