// SPDX-License-Identifier: MIT
// Luenberger-like observer (15) of a plant whose linear part is known: z = x_hat,
//   x_hat' = A x_hat + B u + g_hat(x_hat; theta) + G (y - C x_hat)
#pragma once

#include <Eigen/Core>

#include "trainer/structures/network_lanes.h"
#include "trainer/structures/observer_gain.h"

namespace nlo::trainer {

template <class Scalar>
class LuenbergerLanes final : public OdeDynamics<Scalar> {
 public:
  LuenbergerLanes(const LinearPart& known, NetworkShape shape, Normalisation inputs)
      : OdeDynamics<Scalar>(static_cast<int>(known.gain.rows()),
                            static_cast<int>(known.gain.cols() + known.input_matrix.cols()), shape.parameters),
        closed_loop_((known.state_matrix - known.gain * known.output_matrix).cast<Scalar>()),
        gain_(known.reading_gain().cast<Scalar>()),
        network_(std::move(shape), std::move(inputs)) {}

  void prepare(const Scalar* theta) override { network_.prepare(theta); }

  void derivative(int slot, const Scalar* z, const Scalar* y, Scalar* dz) override {
    network_.set_input(slot, 0, this->rows(), z);
    const Scalar* g = network_.run(slot);
    rows_of(dz, this->rows()) =
        rows_of(g, this->rows()) + closed_loop_ * rows_of(z, this->rows()) + gain_ * rows_of(y, this->readings());
  }

  void pull_back(int slot, const Scalar* cotangent, Scalar* cotangent_z) override {
    network_.pull_back(slot, cotangent, this->rows(), cotangent_z);
    rows_of(cotangent_z, this->rows()) += closed_loop_.transpose() * rows_of(cotangent, this->rows());
  }

  void clear_gradient() override { network_.clear_gradient(); }
  void gradient(Scalar* out) const override { network_.gradient(out); }

 private:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Rows = Eigen::Matrix<Scalar, Eigen::Dynamic, kGroup, Eigen::RowMajor>;
  static Eigen::Map<Rows> rows_of(Scalar* data, int rows) { return {data, rows, kGroup}; }
  static Eigen::Map<const Rows> rows_of(const Scalar* data, int rows) { return {data, rows, kGroup}; }

  Matrix closed_loop_, gain_;
  NetworkLanes<Scalar> network_;
};

}  // namespace nlo::trainer
