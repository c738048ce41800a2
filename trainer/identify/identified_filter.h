// SPDX-License-Identifier: MIT
// EKF and UKF of an identified plant, and their estimates of the logged states. If no output measures an angle and it
// may start anywhere, a single filter may not find it. Then a bank of filters starts around the turn (filter_bank.h).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/identification.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/filters/sigma_point_filter.h"
#include "trainer/judge/filters/step_cost.h"

namespace nlo::trainer {

/// An angle that no output measures, and whose initial deviation covers its whole turn.
struct HiddenAngle {
  Eigen::Index state;    ///< row among the states of the plant
  Eigen::Index log_row;  ///< row among the logged states
  double wrap;           ///< its turn
};

/// Returns the hidden angles among the logged states.
std::vector<HiddenAngle> hidden_angles(const Identification& identification,
                                       const std::vector<codegen::Channel>& logged_states);

class IdentifiedFilter {
 public:
  /// Makes a filter for the plant with parameters `p` on logs with the channels of `logs`.
  IdentifiedFilter(const Identification& identification, Eigen::VectorXd p, const Dataset& logs);

  /// Returns the tuned values as log10: the process noise of each state whose start value is above 0, the deviation of
  /// R of each output, and the scale of P0's deviation.
  Eigen::VectorXd tuning() const;
  FilterKnowledge knowledge(const Eigen::VectorXd& tuning) const;
  std::string describe(const Eigen::VectorXd& tuning) const;

  /// Returns estimates of the logged states, n_x of the logs x N. A state with the name of an output starts at its
  /// first measurement, with the variance of R. Makes its own plant, so any thread may call it.
  Eigen::MatrixXd estimate(PointSet kind, const Eigen::VectorXd& tuning, const Trajectory& run) const;

  /// Returns estimates by the filter of the bank that starts nearest to the logged angles. It takes a small part of the
  /// time and is used for tuning. Equals estimate() if the bank has one filter.
  Eigen::MatrixXd estimate_from_nearest(PointSet kind, const Eigen::VectorXd& tuning, const Trajectory& run) const;

  /// Returns the cost of a sample `period_s` after the last one.
  StepCost step_cost(PointSet kind, double period_s) const;

 private:
  LanePlant make_plant() const;
  /// Returns the initial states of the bank for a run, n_x x members.
  Eigen::MatrixXd starts(const Trajectory& run) const;
  Eigen::MatrixXd estimate_from(const Eigen::MatrixXd& starts, PointSet kind, const Eigen::VectorXd& tuning,
                                const Trajectory& run) const;
  Eigen::Index members() const;

  const Identification& identification_;
  Eigen::VectorXd p_, output_wraps_, state_wraps_;
  std::vector<Eigen::Index> output_rows_, input_rows_;  ///< rows of the plant's channels among those of the logs
  std::vector<Eigen::Index> state_rows_;                ///< rows of the logged states among the plant's
  std::vector<HiddenAngle> hidden_;
  Eigen::Index around_ = 1;  ///< number of starts around the turn of each hidden angle
};

}  // namespace nlo::trainer
