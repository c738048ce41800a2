// SPDX-License-Identifier: MIT
// Whether a latent state lies where training has been: the runtime's in_domain() for the model's equations.
#pragma once

#include <Eigen/Core>

#include "codegen/model/latent_step.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

class LatentDomain {
 public:
  explicit LatentDomain(const Model& model) : low_(model.latent_min), high_(model.latent_max) {
    steady_ = Eigen::MatrixXd::Zero(model.nz(), model.nr());
    const Eigen::MatrixXd gain = steady_gain(model);
    for (int j = 0; j < model.nr(); ++j)
      if (is_relative(model, j)) steady_.col(j) = gain.col(j);
  }

  /// z (n_z) at a sample whose readings were taken as y (n_r), angles unwrapped: z is judged relative to S y of those.
  template <class Z, class Y>
  bool contains(const Eigen::MatrixBase<Z>& z, const Eigen::MatrixBase<Y>& y) const {
    const Eigen::VectorXd relative = z - steady_ * y;
    return (relative.array() >= low_.array()).all() && (relative.array() <= high_.array()).all();
  }

 private:
  Eigen::VectorXd low_, high_;
  Eigen::MatrixXd steady_;  ///< S for relative outputs, 0 for the others; n_z x n_r
};

}  // namespace nlo::codegen
