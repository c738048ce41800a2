// SPDX-License-Identifier: MIT
// A plant and runs of it side by side, a lane each: filters on lanes take one step of many runs at once, so that trying a
// hundred tunings of a filter takes seconds.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// dx/dt = f(x, u), y = h(x). A batch of points is blocks of L columns, one column per lane, behind each other.
struct LanePlant {
  using Map = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)>;
  using DrivenMap = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u)>;

  Eigen::Index nx = 0, ny = 0;
  DrivenMap f;                   ///< n_x x B for n_x x B and n_u x B; 0 x 0: u = 0
  Map h;                         ///< n_y x B
  Eigen::VectorXd output_wraps;  ///< full turns of outputs that are angles, else 0; n_y
};

/// `plant` as it is; kept alive. Not for two threads at once.
LanePlant lane_plant(const std::shared_ptr<const Plant>& plant);

/// What the sensors of L runs gave, all with the same samples.
struct LaneRuns {
  double sample_period_s = 0.0;
  std::vector<Eigen::MatrixXd> outputs;  ///< N of n_y x L; NaN: did not arrive
  std::vector<Eigen::MatrixXd> inputs;   ///< N of n_u x L, or empty
  bool held_inputs = false;  ///< the u of a sample has acted since the sample before; else a ramp from there

  Eigen::Index samples() const { return static_cast<Eigen::Index>(outputs.size()); }
  Eigen::Index lanes() const { return outputs.empty() ? 0 : outputs.front().cols(); }
};

/// The same runs `times` times, lane by lane behind each other: for as many tunings of one filter.
LaneRuns repeated(const LaneRuns& runs, Eigen::Index times);

/// One of them.
LaneRuns lane_of(const LaneRuns& runs, Eigen::Index lane);

/// Inputs at both ends of the period that ends with sample k, n_u x L each; 0 x 0 where there are none.
struct LaneInputs {
  Eigen::MatrixXd from, to;
};
LaneInputs inputs_before(const LaneRuns& runs, Eigen::Index k);

/// x (n_x x (blocks L)) one sample period later, by one step of RK4.
Eigen::MatrixXd advance(const LanePlant& plant, const Eigen::MatrixXd& x, double h, const LaneInputs& u);

/// A filter on lanes. step() is called for the samples k = 0, 1, ... in order and gives its estimates, n_x x L.
class LaneFilter {
 public:
  virtual ~LaneFilter() = default;
  virtual Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) = 0;

  /// How often a lane left the finite numbers and began anew.
  virtual int restarts() const { return 0; }
};

}  // namespace nlo::trainer
