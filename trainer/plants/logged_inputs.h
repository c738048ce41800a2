// SPDX-License-Identifier: MIT
// Recorded inputs, from which [excitation] draws for the kind "log". Each run takes a stretch of the log from
// a random time on, the same for all of its inputs, which belong together; a run longer than the log goes on at its
// beginning. Values are read at the run's samples, on the straight line between rows; between samples they are held as
// all drawn inputs are (simulate_runs.h).
#pragma once

#include <Eigen/Core>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct LoggedInputs {
  Eigen::VectorXd time_s;  ///< rows, increasing, from 0
  Eigen::MatrixXd values;  ///< n_u x rows; 0 x 0: no log
};

/// Reads excitation.log where `kinds` has "log", else nothing. Throws codegen::Error naming file, column and line: see
/// CsvTable; fewer than two rows; time that does not increase; a value outside of the input's range.
LoggedInputs read_logged_inputs(const ExcitationConfig& excitation, const SimulationConfig& simulation);

/// n_u x N of the stretch that begins at `start_s`, 0 <= start_s <= the log's duration.
Eigen::MatrixXd stretch_of(const LoggedInputs& log, double start_s, double sample_period_s, Eigen::Index samples);

}  // namespace nlo::trainer
