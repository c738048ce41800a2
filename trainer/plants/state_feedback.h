// SPDX-License-Identifier: MIT
// State feedback u = sat(k(x_hat, r)) as in an experiment's [feedback], which closes the loop over an observer.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Name of an input's reference in a law: "r_torque" for "torque".
std::string reference_name(const std::string& input);

/// Whether run i of a set is in the loop: `share` of them, spread evenly.
bool in_closed_loop(const FeedbackConfig& feedback, Eigen::Index run);

class LoopExpressions;

class StateFeedback {
 public:
  /// Laws over the states that [plant] `estimated` names (all of the plant's, where it names none), the references and
  /// the nominal parameters. Throws codegen::Error naming the law and the position in it, or the state that it reads
  /// and the observer does not estimate.
  ///   config  the section that `plant` was made from
  StateFeedback(const FeedbackConfig& feedback, const Plant& plant, const PlantConfig& config);
  ~StateFeedback();

  /// u, n_u, within the limits of the actuators. Throws codegen::Error where a law is no number.
  ///   x_hat      one for each estimated state, in the order of `estimated`
  ///   reference  n_u, one for each input
  Eigen::VectorXd operator()(const Eigen::VectorXd& x_hat, const Eigen::VectorXd& reference);

  /// u clipped to the limits; an actuator at rest has clipped(0).
  Eigen::VectorXd clipped(const Eigen::VectorXd& u) const;

 private:
  std::unique_ptr<LoopExpressions> laws_;
  std::vector<Eigen::Index> rows_;  ///< rows of the estimated states among the plant's
  Eigen::VectorXd x_hat_;           ///< n_x; 0 where nothing is estimated, and no law reads it
  Eigen::VectorXd low_, high_;
};

/// Cost of a sample of the loop, [feedback] cost: an expression over states, inputs and nominal parameters.
class LoopCost {
 public:
  /// Throws codegen::Error naming the key and the position in it.
  LoopCost(const FeedbackConfig& feedback, const Plant& plant, const PlantParameters& constants);
  ~LoopCost();

  /// Throws codegen::Error where it is no number.
  ///   x  n_x
  ///   u  n_u, as the actuator holds it
  double operator()(const Eigen::VectorXd& x, const Eigen::VectorXd& u);

 private:
  std::unique_ptr<LoopExpressions> expression_;
};

}  // namespace nlo::trainer
