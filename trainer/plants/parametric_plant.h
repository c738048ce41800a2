// SPDX-License-Identifier: MIT
// A plant by expressions whose parameters change while it runs, for identification and its
// filters.
//   x' = f(x, u, p),  y = h(x, u, p)
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Evaluates in place: one thread at a time.
class ParametricPlant {
 public:
  /// Throws KeyError with the expression and the position in it, or with a wrong name: used twice, not an identifier,
  /// or an input or parameter without effect. The outputs have the names of `output_names`.
  explicit ParametricPlant(const PlantConfig& config);
  ~ParametricPlant();

  const std::vector<std::string>& states() const { return states_; }
  const std::vector<std::string>& outputs() const { return outputs_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  const std::vector<std::string>& parameters() const { return parameters_; }
  Eigen::Index nx() const { return static_cast<Eigen::Index>(states_.size()); }
  Eigen::Index ny() const { return static_cast<Eigen::Index>(outputs_.size()); }
  Eigen::Index nu() const { return static_cast<Eigen::Index>(inputs_.size()); }
  Eigen::Index np() const { return static_cast<Eigen::Index>(parameters_.size()); }

  /// Sets p, n_p. Before the first call, p has the values of [plant]. Outside of the domain of an expression, values
  /// are NaN, never an exception.
  void set_parameters(const Eigen::VectorXd& p);
  Eigen::VectorXd parameter_values() const;

  /// Returns f(x, u), n_x; `u`: n_u.
  Eigen::VectorXd derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& u);

  /// Returns h(x, u), n_y.
  Eigen::VectorXd output(const Eigen::VectorXd& x, const Eigen::VectorXd& u);

 private:
  struct Formulas;
  std::vector<std::string> states_, outputs_, inputs_, parameters_;
  std::unique_ptr<Formulas> formulas_;
};

}  // namespace nlo::trainer
