// SPDX-License-Identifier: MIT
// Reads files for a report: metrics.csv of a training, and the JSON file of examples/control_loop, which runs the
// exported observer in a periodic thread.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// One entry per row; NaN for empty cells.
struct TrainingCurves {
  Eigen::VectorXd step, elapsed_s, loss, train_rmse, validation_rmse, learning_rate;
  std::vector<Eigen::VectorXcd> eigenvalues;  ///< one curve per eigenvalue; a pair has one curve
};

/// Reads columns by their headings, in any order; unknown ones are ignored. Throws codegen::Error with `name`, line and
/// reason: no "step" column, a row with another number of cells, a cell that is not a number.
TrainingCurves parse_training_curves(std::string_view csv, const std::string& name);

TrainingCurves read_training_curves(const std::string& path);

struct ControlLoopResult {
  struct Quantiles {
    double p50 = 0.0, p99 = 0.0, p99_9 = 0.0, max = 0.0;  ///< [ns]
  };
  struct Bucket {
    double below_ns = 0.0;  ///< upper limit
    double count = 0.0;
  };

  double rate_hz = 0.0, noise_std = 0.0;
  long ticks = 0, missed_deadlines = 0, faults = 0, outside_domain = 0;
  double rms_error = 0.0, settled_rms_error = 0.0;
  bool real_time_priority = false, memory_locked = false;
  Quantiles step_and_estimate, wake_up_lateness;
  std::vector<Bucket> histogram;  ///< times of step + estimate, increasing
};

/// Throws codegen::Error with `name` and the field that is missing or of the wrong type.
ControlLoopResult parse_control_loop(std::string_view json, const std::string& name);

ControlLoopResult read_control_loop(const std::string& path);

/// Returns the time in a suitable unit: "310 ns", "1.21 µs".
std::string nanoseconds(double ns);

}  // namespace nlo::trainer
