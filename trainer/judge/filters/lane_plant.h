// SPDX-License-Identifier: MIT
// A plant and runs of it side by side, one lane each. A filter on lanes takes a step of many runs at once, so that a
// hundred tunings of a filter take seconds.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// dx/dt = f(x, u), y = h(x, u). A batch of points has blocks of L columns, one column per lane, one block after
/// another.
struct LanePlant {
  using Map = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u)>;

  Eigen::Index nx = 0, ny = 0;
  Map f, h;                          ///< Map (n_x x B, n_u x B) to n_x x B and n_y x B; n_u x B is 0 x 0 for u = 0
  Eigen::VectorXd output_wraps;      ///< full turns of outputs that are angles, else 0; n_y
  Eigen::VectorXd state_wraps = {};  ///< full turns of states that are angles, else 0; n_x; empty: no state is an angle
  /// Longest step of RK4. A longer sample period is divided evenly.
  double longest_step_s = std::numeric_limits<double>::infinity();
};

/// Returns the plant as a LanePlant, which keeps it alive. Two threads must not share it.
LanePlant lane_plant(const std::shared_ptr<const Plant>& plant);

/// Readings of the sensors in L runs with the same sample times.
struct LaneRuns {
  double sample_period_s = 0.0;
  std::vector<Eigen::MatrixXd> outputs;  ///< N of n_y x L; NaN: did not arrive
  std::vector<Eigen::MatrixXd> inputs;   ///< N of n_u x L, or empty
  bool held_inputs = false;              ///< true: the u of a sample has acted since the last sample; else it is a ramp
  Eigen::VectorXd time_s = {};           ///< N; empty: samples are one period apart

  /// Returns the time from sample k - 1 to k.
  double step_s(Eigen::Index k) const { return time_s.size() > 0 ? time_s[k] - time_s[k - 1] : sample_period_s; }
  /// Returns n_u x L; 0 x 0 without inputs.
  Eigen::MatrixXd inputs_at(Eigen::Index k) const;
  Eigen::Index samples() const { return static_cast<Eigen::Index>(outputs.size()); }
  Eigen::Index lanes() const { return outputs.empty() ? 0 : outputs.front().cols(); }
};

/// Returns one run on one lane; outputs n_y x N, inputs n_u x N or 0 x 0, time_s N.
LaneRuns one_run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s,
                 bool held_inputs);

/// Repeats the runs `times` times, one block of lanes after another, for several tunings of one filter.
LaneRuns repeated(const LaneRuns& runs, Eigen::Index times);

/// Inputs at both ends of the period that ends with sample k, n_u x L each; 0 x 0 without inputs.
struct LaneInputs {
  Eigen::MatrixXd from, to;
};
LaneInputs inputs_before(const LaneRuns& runs, Eigen::Index k);

/// Returns the number of steps of RK4 over `h` seconds.
double rk4_steps(double h, double longest_step_s);

/// Returns x (n_x x (blocks L)) after `h` seconds, by RK4.
Eigen::MatrixXd advance(const LanePlant& plant, const Eigen::MatrixXd& x, double h, const LaneInputs& u);

/// Returns y at x with `u` (n_u x L) in each of its blocks.
Eigen::MatrixXd output_at(const LanePlant& plant, const Eigen::MatrixXd& x, const Eigen::MatrixXd& u);

/// A filter on lanes. step() is called for the samples k = 0, 1, ... in order and returns its estimates, n_x x L.
class LaneFilter {
 public:
  virtual ~LaneFilter() = default;
  virtual Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) = 0;

  /// Returns the number of times that a lane overflowed and was restarted.
  virtual int restarts() const { return 0; }

  /// Returns sqrt(P_ii) of its last estimates, n_x x L; 0 x 0 for a filter without a covariance.
  virtual Eigen::MatrixXd deviations() const { return {}; }
};

/// Results over runs of one lane, n_x x N.
struct FilteredRun {
  Eigen::MatrixXd x_hat, deviations;  ///< deviations: 0 x 0 if not known
};
FilteredRun filtered(LaneFilter& filter, const LaneRuns& run);

}  // namespace nlo::trainer
