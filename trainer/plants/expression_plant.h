// SPDX-License-Identifier: MIT
// A plant written in an experiment file: one expression (see plant_expression.h) per derivative, output and entry of
// the input field, over the names of the states and the parameters. Without an input field, derivatives may name the
// inputs.
#pragma once

#include <memory>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

class ExpressionPlant final : public Plant {
 public:
  /// Throws KeyError with the expression and the position in it, or with the names that do not agree.
  explicit ExpressionPlant(const PlantConfig& config);
  ~ExpressionPlant() override;

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override;
  Eigen::MatrixXd driven_derivative(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) const override;
  bool affine_in_inputs() const override { return inputs().empty() || !input_fields_.empty(); }
  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override;
  Eigen::MatrixXd input_field(const Eigen::MatrixXd& x, Eigen::Index input) const override;

 private:
  class Formulas;
  std::unique_ptr<Formulas> derivative_, output_;
  std::vector<std::unique_ptr<Formulas>> input_fields_;  ///< one per input; empty: derivative_ reads the inputs
};

}  // namespace nlo::trainer
