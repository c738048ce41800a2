// SPDX-License-Identifier: MIT
// Runs of an observer and its monitor, with the true states. The estimation error on them shows the effect of a gate, a
// frozen sensor or a fault.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {

/// One run in flight. Columns are samples.
struct FlownRun {
  Eigen::MatrixXd outputs, inputs, states;  ///< n_y x N with NaN for missing, n_u x N or 0 x 0, n_x x N
  Eigen::VectorXd weight;                   ///< N; 0: the truth is unknown, or no estimate is required
  Eigen::VectorXd time_s;                   ///< N; empty: every step is one sample period

  Eigen::Index samples() const { return outputs.cols(); }
  /// Returns the samples from `first` on.
  FlownRun from(Eigen::Index first) const;
};

std::vector<FlownRun> flown_runs(const ComparedRuns& runs, Eigen::Index most);
std::vector<FlownRun> flown_runs(const Dataset& logs, Eigen::Index most);

/// Returns the deviations of the true states over all runs, n_x. Errors are divided by them, so that all states have
/// equal weight.
Eigen::VectorXd state_deviations(const std::vector<FlownRun>& runs);

/// Sum of the squared errors of x_hat in deviations, from sample `first` to sample `end` - 1 or to the last one. An
/// angle has an error of at most half a turn.
struct ErrorSum {
  double squares = 0.0, weight = 0.0;
  double rms() const;
  ErrorSum& operator+=(const ErrorSum& other);
};
ErrorSum error_sum(const codegen::Model& model, const FlownRun& run, const Eigen::MatrixXd& x_hat,
                   const Eigen::VectorXd& deviations, Eigen::Index first = 0,
                   Eigen::Index end = std::numeric_limits<Eigen::Index>::max());

/// Runs the observer over a run, with the gate of the monitor.
codegen::WatchedRun fly(const codegen::Model& model, const codegen::Monitor& monitor, const FlownRun& run);

/// Returns the monitor with an open gate and without detection of frozen sensors, so that it rejects nothing.
codegen::Monitor without_gate(codegen::Monitor monitor);

}  // namespace nlo::trainer
