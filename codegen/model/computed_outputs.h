// SPDX-License-Identifier: MIT
// Outputs that no sensor measures: expressions over those that are measured and over the inputs, behind the measured
// ones. To the latent system and to T* they are outputs as any other; step() does not take them.
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
  /// `inputs`: those that are read beside the outputs. Throws Error, with the output's name and the fix, where an
  /// expression cannot be read, reads an angle or a computed output, or stands before a measured output.
  ComputedOutputs(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs);

  bool none() const { return expressions_.empty(); }
  int first() const { return first_; }                                 ///< of the outputs: how many are measured
  const std::vector<Expression>& all() const { return expressions_; }  ///< of output first(), first() + 1, ...

  /// Computes rows first() ... of `outputs` (n_y x N) from the others and `inputs` (n_u x N). Not-a-number of a
  /// part gives not-a-number.
  void fill(Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs) const;

 private:
  int first_ = 0, outputs_ = 0;
  std::vector<Expression> expressions_;
};

/// How many of them, the first, are measured.
int measured_outputs(const std::vector<Channel>& outputs);

}  // namespace nlo::codegen
