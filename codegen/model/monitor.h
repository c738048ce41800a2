// SPDX-License-Identifier: MIT
// What watches an observer in flight, as its model file keeps it: nlo/monitor.h has the equations.
#pragma once

#include <Eigen/Core>

namespace nlo::codegen {

struct Monitor {
  Eigen::MatrixXd prediction;      ///< P, n_y x (n_z + n_r + n_x): change of y over a sample from [z - S y; y; x_hat]
  Eigen::VectorXd offset;          ///< c, n_y
  Eigen::VectorXd deviation;       ///< of the innovation, n_y, in the outputs' units
  Eigen::VectorXd least_variance;  ///< n_y
  Eigen::VectorXd latent_mean, latent_deviation;                  ///< n_z, of z - S y
  Eigen::VectorXd windows_s;                                      ///< time constants of the averages
  Eigen::MatrixXd mean_limit, variance_limit, correlation_limit;  ///< n_y x windows
  Eigen::VectorXd latent_limit;                                   ///< one for each window
  Eigen::VectorXd missing_limit;                                  ///< n_y, a share
  double gate = 0.0;                                              ///< in deviations
  Eigen::VectorXd most_equal;          ///< n_y, equal readings in a row, then the sensor is frozen; 0: it never is
  Eigen::VectorXd resting;             ///< n_y, in the outputs' units: the reading that may stay the same while ...
  Eigen::VectorXd witness;             ///< n_y, ... this output is at rest, too ...
  Eigen::VectorXd rest_min, rest_max;  ///< n_y, ... within this range
  double armed_after_s = 0.0;
  double false_alarms_per_hour = 0.0;  ///< that the limits were set for ...
  double hours = 0.0;                  ///< ... on so many hours of runs

  Eigen::Index windows() const { return windows_s.size(); }
  bool freezes_none() const { return (most_equal.array() == 0.0).all(); }
};

/// Readings of output j in a row that repeat the one before, but those of a sensor at rest, until it is frozen.
class Repeats {
 public:
  bool frozen(const Monitor& monitor, Eigen::Index j) const {
    return monitor.most_equal(j) > 0.0 && equal_ >= monitor.most_equal(j);
  }
  int equal() const { return equal_; }

  /// After a reading, and that of its witness in the same sample (NaN: missing).
  void add(const Monitor& monitor, Eigen::Index j, double y, double witness) {
    const bool moves = witness < monitor.rest_min(j) || witness > monitor.rest_max(j);
    const bool at_rest = y == monitor.resting(j) && !moves && !frozen(monitor, j);
    equal_ = y != raw_ || at_rest ? 0 : equal_ + 1;
    raw_ = y;
  }

 private:
  double raw_ = 0.0;
  int equal_ = 0;
};

/// Samples after a start without alarm.
int armed_after(const Monitor& monitor, double sample_period_s);

}  // namespace nlo::codegen
