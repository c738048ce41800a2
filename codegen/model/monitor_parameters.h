// SPDX-License-Identifier: MIT
// The monitor of an observer in its model file. nlo/monitor.h has the equations.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

namespace nlo::codegen {

struct Monitor {
  /// P, n_y x (n_z + n_r + n_x): change of y over a sample from [z - S y; y; x_hat].
  Eigen::MatrixXd prediction;
  Eigen::VectorXd offset;  ///< c, n_y
  /// Standard deviation of the innovation when z is at its mean, n_y, in the units of the outputs.
  Eigen::VectorXd deviation;
  Eigen::VectorXd least_variance;                                 ///< n_y
  Eigen::VectorXd latent_mean, latent_deviation;                  ///< n_z, of z - S y
  Eigen::VectorXd windows_s;                                      ///< time constants of the averages
  Eigen::MatrixXd mean_limit, variance_limit, correlation_limit;  ///< n_y x windows
  Eigen::VectorXd latent_limit;                                   ///< one for each window
  Eigen::VectorXd missing_limit;                                  ///< n_y, a share
  double gate = 0.0;                 ///< in deviations; its square is kNoLimit if the gate is always open
  Eigen::VectorXd most_equal;        ///< n_y, equal readings in a row after which a sensor is frozen; 0: never
  Eigen::VectorXd resting;           ///< n_y, in the outputs' units: the reading of a sensor at rest, which may repeat
  Eigen::VectorXd reference_sensor;  ///< n_y, index of the output that shows whether the sensor is at rest
  Eigen::VectorXd rest_min, rest_max;  ///< n_y, range of that output at rest
  Eigen::VectorXd most_moved;          ///< n_y, predicted change during equal readings after which a sensor is frozen,
                                       ///< in deviations of the innovation; 0: never
  Eigen::VectorXd motion;              ///< n_y, growth of the innovation per mean deviation of z from its mean
  Eigen::MatrixXd row;                 ///< n_x x (n_z + n_r): linear fit of x_hat by [z - S y; y]
  Eigen::VectorXd row_offset;          ///< n_x
  Eigen::VectorXd row_deviation;       ///< n_x, of x_hat from its fit, in the states' units; 0: not compared
  Eigen::VectorXd disagreement_limit;  ///< n_x, in deviations
  Eigen::VectorXd replaces;            ///< n_y, 1: predictions replace missing and rejected measurements; empty: none
  double armed_after_s = 0.0;
  double false_alarms_per_hour = 0.0;  ///< rate for which the limits were set
  double hours = 0.0;                  ///< length of the runs on which they were set [h]
  std::vector<std::string> lowered;    ///< limits that were lowered when the file was read; not written

  Eigen::Index windows() const { return windows_s.size(); }
  bool freezes_none() const { return (most_equal.array() == 0.0).all() && (most_moved.array() == 0.0).all(); }
  bool scales_with_motion() const { return (motion.array() != 0.0).any(); }
  bool replaces_any() const { return (replaces.array() != 0.0).any(); }
  bool compares_row() const { return (row_deviation.array() != 0.0).any(); }
};

/// Sets the constants so that no sensor is ever considered frozen.
void leave_out_frozen(Monitor& monitor, Eigen::Index outputs);
/// Sets the constants so that the size of innovations is constant and no state is compared with its linear fit.
void leave_out_motion_and_row(Monitor& monitor, Eigen::Index outputs, Eigen::Index states, Eigen::Index features);

/// Counts successive equal readings of output j, and adds up the predicted changes meanwhile.
class Repeats {
 public:
  bool frozen() const { return frozen_; }
  int equal() const { return equal_; }
  double moved() const { return moved_; }

  /// Adds a reading, that of its reference sensor in the same sample (NaN: missing), and the change that was predicted
  /// [deviations].
  void add(const Monitor& monitor, Eigen::Index j, double y, double reference_sensor, double predicted) {
    const bool moves = reference_sensor < monitor.rest_min(j) || reference_sensor > monitor.rest_max(j);
    const bool at_rest = y == monitor.resting(j) && !moves && !frozen_, repeats = y == raw_;
    moved_ = repeats ? moved_ + predicted : 0.0;
    equal_ = !repeats || at_rest ? 0 : equal_ + 1;
    frozen_ = (frozen_ && repeats) || (monitor.most_equal(j) > 0.0 && equal_ >= monitor.most_equal(j)) ||
              (monitor.most_moved(j) > 0.0 && std::abs(moved_) > monitor.most_moved(j));
    raw_ = y;
  }

 private:
  double raw_ = 0.0, moved_ = 0.0;
  int equal_ = 0;
  bool frozen_ = false;
};

/// Returns the number of samples after a start before the monitor is armed.
int armed_after(const Monitor& monitor, double sample_period_s);

}  // namespace nlo::codegen
