// SPDX-License-Identifier: MIT
// General observer (11): z' = F(z, y; theta), one network over [z; y]. Its linear path starts as D z + F y of a stable
// linear system, so training starts with an observer instead of random dynamics.
#pragma once

#include "trainer/structures/network_lanes.h"

namespace nlo::trainer {

template <class Scalar>
class GeneralLanes final : public OdeDynamics<Scalar> {
 public:
  /// shape: n_z + n_r inputs, n_z outputs.
  GeneralLanes(int readings, NetworkShape shape, Normalisation inputs)
      : OdeDynamics<Scalar>(shape.outputs(), readings, shape.parameters),
        network_(std::move(shape), std::move(inputs)) {}

  void prepare(const Scalar* theta) override { network_.prepare(theta); }

  void derivative(int slot, const Scalar* z, const Scalar* y, Scalar* dz) override {
    network_.set_input(slot, 0, this->rows(), z);
    network_.set_input(slot, this->rows(), this->readings(), y);
    std::copy_n(network_.run(slot), this->rows() * kGroup, dz);
  }

  void pull_back(int slot, const Scalar* cotangent, Scalar* cotangent_z) override {
    network_.pull_back(slot, cotangent, this->rows(), cotangent_z);
  }

  void clear_gradient() override { network_.clear_gradient(); }
  void gradient(Scalar* out) const override { network_.gradient(out); }

 private:
  NetworkLanes<Scalar> network_;
};

}  // namespace nlo::trainer
