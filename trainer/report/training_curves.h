// SPDX-License-Identifier: MIT
// metrics.csv of a training run, read back for plotting.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// One entry per row; what a row leaves empty is NaN.
struct TrainingCurves {
  Eigen::VectorXd step, elapsed_s, loss, train_rmse, validation_rmse, learning_rate;
  std::vector<Eigen::VectorXcd> eigenvalues;  ///< one curve per eigenvalue; a pair is one
};

/// Columns by their headings, in any order; unknown ones are passed over. Throws codegen::Error naming `name`, line and
/// what is wrong: no "step" column, a ragged row, a cell that is no number.
TrainingCurves parse_training_curves(std::string_view csv, const std::string& name);

TrainingCurves read_training_curves(const std::string& path);

}  // namespace nlo::trainer
