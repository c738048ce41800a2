// SPDX-License-Identifier: MIT
// Recorded inputs for the kind "log" of [excitation]. Each run uses a part of the log that starts at a random time,
// which is the same for all inputs of the run. A run longer than the log continues at the beginning of the log. Values
// at the samples of the run lie on the straight line between rows; between samples they are held like all drawn inputs
// (simulate_runs.h).
#pragma once

#include <Eigen/Core>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct LoggedInputs {
  Eigen::VectorXd time_s;  ///< rows, increasing, from 0
  Eigen::MatrixXd values;  ///< n_u x rows; 0 x 0: no log
};

/// Reads excitation.log if `kinds` has "log", otherwise nothing. Throws codegen::Error with file, column and line: see
/// CsvTable; for fewer than two rows; for time that does not increase; for a value outside of the input's range.
LoggedInputs read_logged_inputs(const ExcitationConfig& excitation, const SimulationConfig& simulation);

/// Returns n_u x N values from `start_s` on, 0 <= start_s <= the log's duration.
Eigen::MatrixXd stretch_of(const LoggedInputs& log, double start_s, double sample_period_s, Eigen::Index samples);

}  // namespace nlo::trainer
