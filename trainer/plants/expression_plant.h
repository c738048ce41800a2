// SPDX-License-Identifier: MIT
// A plant written in an experiment file: one expression per derivative and output, over the names of the states and the
// parameters, in muParser's language (+ - * / ^, sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt abs
// sign min max, a < b ? c : d) with the constant pi.
#pragma once

#include <memory>

#include "trainer/config.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

class ExpressionPlant final : public Plant {
 public:
  /// Throws codegen::Error naming the expression and the position in it, or the names that do not fit.
  explicit ExpressionPlant(const PlantConfig& config);
  ~ExpressionPlant() override;

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override;
  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override;

 private:
  class Formulas;
  std::unique_ptr<Formulas> derivative_, output_;
};

}  // namespace nlo::trainer
