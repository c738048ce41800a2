// SPDX-License-Identifier: MIT
// The domain of a model, as in in_domain() of the runtime, and the box of a model that saturates (nlo/saturation.h).
#pragma once

#include <Eigen/Core>

#include "codegen/model/latent_step.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

/// Limits of the z (z - S y for relative outputs) that T* reads: the domain and a margin of `saturation` half ranges on
/// each side. For a model that saturates; n_z each.
struct LatentReach {
  Eigen::VectorXd min, max;

  explicit LatentReach(const Model& model) {
    const Eigen::VectorXd margin = 0.5 * model.saturation * (model.latent_max - model.latent_min);
    min = model.latent_min - margin;
    max = model.latent_max + margin;
  }
};

class LatentDomain {
 public:
  explicit LatentDomain(const Model& model) : low_(model.latent_min), high_(model.latent_max), reach_(model) {
    steady_ = Eigen::MatrixXd::Zero(model.nz(), model.nr());
    const Eigen::MatrixXd gain = steady_gain(model);
    for (int j = 0; j < model.nr(); ++j)
      if (is_relative(model, j)) steady_.col(j) = gain.col(j);
  }

  /// Returns true if z (n_z) is in the domain. y (n_r): validated readings, angles unwrapped; z is compared with S y.
  template <class Z, class Y>
  bool contains(const Eigen::MatrixBase<Z>& z, const Eigen::MatrixBase<Y>& y) const {
    const Eigen::VectorXd relative = z - steady_ * y;
    return (relative.array() >= low_.array()).all() && (relative.array() <= high_.array()).all();
  }

  /// Returns the saturated z that T* reads, for a model that saturates.
  template <class Z, class Y>
  Eigen::VectorXd saturated(const Eigen::MatrixBase<Z>& z, const Eigen::MatrixBase<Y>& y) const {
    const Eigen::VectorXd rest = steady_ * y, place = z - rest;
    Eigen::VectorXd within = z;
    for (Eigen::Index r = 0; r < within.size(); ++r) {
      if (place(r) < reach_.min(r)) within(r) = rest(r) + reach_.min(r);
      if (place(r) > reach_.max(r)) within(r) = rest(r) + reach_.max(r);
    }
    return within;
  }

  /// Returns S with zero columns for outputs that are not relative, n_z x n_r.
  const Eigen::MatrixXd& relative_gain() const { return steady_; }

 private:
  Eigen::VectorXd low_, high_;
  LatentReach reach_;
  Eigen::MatrixXd steady_;
};

}  // namespace nlo::codegen
