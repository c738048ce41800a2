// SPDX-License-Identifier: MIT
// State feedback u = sat(k(x_hat, r)) of an experiment's [feedback], which closes the loop over an observer.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Returns the name of an input's reference in a law: "r_torque" for "torque".
std::string reference_name(const std::string& input);

/// Returns true if run i of a set is in closed loop. A share `share` of the runs, spread evenly, is in closed loop.
bool in_closed_loop(const FeedbackConfig& feedback, Eigen::Index run);

class LoopExpressions;

class StateFeedback {
 public:
  /// Compiles the laws, which are expressions over the states that [plant] `estimated` names (all states if it is
  /// empty), the references and the nominal parameters. Throws codegen::Error with the law and the position in it, or
  /// with a state that the law uses and the observer does not estimate.
  ///   config  the section that `plant` was made from
  StateFeedback(const FeedbackConfig& feedback, const Plant& plant, const PlantConfig& config);
  ~StateFeedback();

  /// Returns u, n_u, within the limits of the actuators. Throws codegen::Error if a law gives NaN.
  ///   x_hat      one for each estimated state, in the order of `estimated`
  ///   reference  n_u, one for each input
  Eigen::VectorXd operator()(const Eigen::VectorXd& x_hat, const Eigen::VectorXd& reference);

  /// Returns u clipped to the limits. An actuator at rest has clipped(0).
  Eigen::VectorXd clipped(const Eigen::VectorXd& u) const;

 private:
  std::unique_ptr<LoopExpressions> laws_;
  std::vector<Eigen::Index> rows_;  ///< rows of the estimated states among the plant's
  Eigen::VectorXd x_hat_;           ///< n_x; 0 for states that are not estimated, which no law uses
  Eigen::VectorXd low_, high_;
};

/// Cost of a sample of the loop, [feedback] cost: an expression over states, inputs and nominal parameters.
class LoopCost {
 public:
  /// Compiles the cost. Throws codegen::Error with the key and the position of the error in the expression.
  LoopCost(const FeedbackConfig& feedback, const Plant& plant, const PlantParameters& constants);
  ~LoopCost();

  /// Returns the cost. Throws codegen::Error if it is NaN.
  ///   x  n_x
  ///   u  n_u, as the actuator holds it
  double operator()(const Eigen::VectorXd& x, const Eigen::VectorXd& u);

 private:
  std::unique_ptr<LoopExpressions> expression_;
};

}  // namespace nlo::trainer
