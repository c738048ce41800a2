// SPDX-License-Identifier: MIT
// Runs with their true states: a gate, a frozen sensor and a fault are judged on them by the error of the estimate.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {

/// One run as an observer flies it. Columns are samples.
struct FlownRun {
  Eigen::MatrixXd outputs, inputs, states;  ///< n_y x N with NaN for missing, n_u x N or 0 x 0, n_x x N
  Eigen::VectorXd weight;                   ///< N; 0: the truth is unknown there, or no estimate is asked for
  Eigen::VectorXd time_s;                   ///< N; empty: every step is one sample period

  Eigen::Index samples() const { return outputs.cols(); }
  /// The samples from `first` on.
  FlownRun from(Eigen::Index first) const;
};

std::vector<FlownRun> flown_runs(const ComparedRuns& runs, Eigen::Index most);
std::vector<FlownRun> flown_runs(const Dataset& logs, Eigen::Index most);

/// The deviations of the true states over all runs, n_x: errors are divided by them, so that all states count alike.
Eigen::VectorXd state_deviations(const std::vector<FlownRun>& runs);

/// Sum of the squared errors of x_hat in deviations, from sample `first` on. Angles differ by less than half a turn.
struct ErrorSum {
  double squares = 0.0, weight = 0.0;
  double rms() const;
};
ErrorSum error_sum(const codegen::Model& model, const FlownRun& run, const Eigen::MatrixXd& x_hat,
                   const Eigen::VectorXd& deviations, Eigen::Index first = 0);

/// The run behind the monitor's gate.
codegen::WatchedRun fly(const codegen::Model& model, const codegen::Monitor& monitor, const FlownRun& run);

/// The monitor with its gate open and without frozen sensors: it rejects nothing.
codegen::Monitor without_gate(codegen::Monitor monitor);

}  // namespace nlo::trainer
