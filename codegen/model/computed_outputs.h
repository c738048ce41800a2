// SPDX-License-Identifier: MIT
// Computed outputs: expressions of measured outputs and inputs. They follow the measured outputs. The latent system and
// T* read them like any other output; step() does not take them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/model/expression.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

class ComputedOutputs {
 public:
  ComputedOutputs() = default;
  /// `inputs`: the inputs that are readings. Throws Error, with the output's name and the fix, if an expression cannot
  /// be read, reads an angle or a computed output, or stands before a measured output.
  ComputedOutputs(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs);

  bool none() const { return expressions_.empty(); }
  int first() const { return first_; }                                 ///< number of measured outputs
  const std::vector<Expression>& all() const { return expressions_; }  ///< one for each output from first() on

  /// Computes the rows of `outputs` (n_y x N) from first() on, from its other rows and `inputs` (n_u x N). If a part is
  /// NaN, the result is NaN.
  void fill(Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs) const;

 private:
  int first_ = 0, outputs_ = 0;
  std::vector<Expression> expressions_;
};

/// Returns the number of measured outputs, which come first.
int measured_outputs(const std::vector<Channel>& outputs);

}  // namespace nlo::codegen
