// SPDX-License-Identifier: MIT
// A network in a right-hand side. Each stage of a Runge-Kutta step has a slot: a block of eight trajectories, whose
// inputs are normalised when they are set.
//   out = network(u),  u = (in - mean) / scale
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "trainer/gradients/nn/network_block.h"
#include "trainer/gradients/sensitivity/ode_dynamics.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

template <class Scalar>
class NetworkLanes {
 public:
  NetworkLanes(NetworkShape shape, Normalisation inputs) : shape_(std::move(shape)), inputs_(std::move(inputs)) {
    for (int slot = 0; slot < OdeDynamics<Scalar>::kSlots; ++slot) blocks_.emplace_back(shape_);
    transposed_.resize(static_cast<std::size_t>(shape_.parameters));
  }
  NetworkLanes(const NetworkLanes&) = delete;
  NetworkLanes& operator=(const NetworkLanes&) = delete;

  const NetworkShape& shape() const { return shape_; }

  void prepare(const Scalar* theta) {
    theta_ = theta;
    transpose_weights(shape_, theta, transposed_.data());
  }

  /// Writes rows [first, first + count) of the inputs.
  void set_input(int slot, int first, int count, const Scalar* in) {
    Scalar* u = block(slot).input();
    for (int r = first; r < first + count; ++r) {
      const auto i = static_cast<std::size_t>(r);
      const auto mean = static_cast<Scalar>(inputs_.mean[i]), inverse = static_cast<Scalar>(1.0 / inputs_.scale[i]);
      for (int l = 0; l < kGroup; ++l) u[r * kGroup + l] = (in[(r - first) * kGroup + l] - mean) * inverse;
    }
  }

  const Scalar* run(int slot) {
    block(slot).forward(theta_);
    return block(slot).output();
  }

  /// Adds the gradient of the parameters, and writes the cotangents of inputs [0, count).
  void pull_back(int slot, const Scalar* cotangent, int count, Scalar* cotangent_in) {
    std::copy_n(cotangent, shape_.outputs() * kGroup, block(slot).output_cotangent());
    block(slot).backward(theta_, transposed_.data());
    const Scalar* u = block(slot).input_cotangent();
    for (int r = 0; r < count; ++r) {
      const auto inverse = static_cast<Scalar>(1.0 / inputs_.scale[static_cast<std::size_t>(r)]);
      for (int l = 0; l < kGroup; ++l) cotangent_in[r * kGroup + l] = u[r * kGroup + l] * inverse;
    }
  }

  void clear_gradient() {
    for (Block& block : blocks_) block.clear_gradient();
  }

  void gradient(Scalar* out) const {
    std::vector<Scalar> part(static_cast<std::size_t>(shape_.parameters));
    std::fill_n(out, part.size(), Scalar(0));
    for (const Block& block : blocks_) {
      block.gradient(part.data());
      for (std::size_t i = 0; i < part.size(); ++i) out[i] += part[i];
    }
  }

 private:
  using Block = NetworkBlock<Scalar, kGroup>;
  Block& block(int slot) { return blocks_[static_cast<std::size_t>(slot)]; }

  NetworkShape shape_;
  Normalisation inputs_;
  std::vector<Block> blocks_;  // one for each slot
  std::vector<Scalar> transposed_;
  const Scalar* theta_ = nullptr;
};

}  // namespace nlo::trainer
