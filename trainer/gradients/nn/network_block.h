// SPDX-License-Identifier: MIT
// Forward and backward passes of a network over a block of samples that stays in cache. Within a block a row holds one
// neuron for all samples, so every operation runs along the samples in whole SIMD registers. Beside the values (reverse
// mode) there are tangents (forward mode), and the reverse of both together, for a loss of dT/dx.
//   values     v_l = W_l a_{l-1} + b_l,   a_l = s(v_l)
//   tangents   v'_l = W_l a'_{l-1},       a'_l = s'(v_l) v'_l          (a'_0 = the direction: out' = J direction)
//   reverse    V' = s' A',  V = s' A + s'' v' A',  dW = V a^T + V' a'^T,  A_{l-1} = W^T V,  A'_{l-1} = W^T V'
// Wide blocks of float train T*; narrow ones run inside a Runge-Kutta step; double is for tests of gradients.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "nlo/kernels/simd.h"
#include "trainer/base/aligned_vector.h"
#include "trainer/gradients/nn/network_shape.h"

namespace nlo::trainer {

template <class Scalar, int kColumns>
class NetworkBlock {
 public:
  /// Scalars in a register of this block.
  static constexpr int kWidth = std::min(simd::kLanes<Scalar>, kColumns);
  /// Distance between rows. In wide blocks it is not a power of two, so that rows spread over the sets of the cache.
  static constexpr int kStride = kColumns >= 128 ? kColumns + 16 : kColumns;
  static_assert(kColumns % kWidth == 0);

  /// with_tangents: also allocates memory for the passes with tangents.
  explicit NetworkBlock(const NetworkShape& shape, bool with_tangents = false);

  /// Returns the inputs u, n_in rows, for the caller to fill. Columns behind the samples must be finite.
  Scalar* input() { return values_.activations[0].data(); }
  /// Returns the outputs n, n_out rows.
  Scalar* output() { return values_.activations.back().data(); }
  /// Returns the cotangent of the outputs, n_out rows, for the caller to fill, with zeros behind the samples.
  /// backward() overwrites it.
  Scalar* output_cotangent() { return values_.last_cotangent(); }
  /// Returns the cotangent of the inputs, n_in rows, after backward().
  const Scalar* input_cotangent() const { return values_.input_cotangent.data(); }

  /// The next functions return the tangents of the inputs and outputs, and their cotangents.
  Scalar* input_tangent() { return tangents_.activations[0].data(); }
  Scalar* output_tangent() { return tangents_.activations.back().data(); }
  Scalar* output_tangent_cotangent() { return tangents_.last_cotangent(); }
  const Scalar* input_tangent_cotangent() const { return tangents_.input_cotangent.data(); }

  void forward(const Scalar* parameters);
  /// Computes output_tangent() = J input_tangent(). Call it after forward().
  void forward_tangents(const Scalar* parameters);

  /// Adds to the gradient. transpose_weights() makes `transposed` once per step.
  void backward(const Scalar* parameters, const Scalar* transposed);
  /// Backward pass for a loss of outputs and their tangents. The caller must fill both cotangents.
  void backward_tangents(const Scalar* parameters, const Scalar* transposed);

  void clear_gradient();
  /// Writes the gradient (n parameters).
  void gradient(Scalar* out) const;

 private:
  using Rows = AlignedVector<Scalar>;
  struct Pass {
    std::vector<Rows> activations;      // a_0 ... a_L, (width x kStride) each
    std::vector<Rows> pre_activations;  // v_l, only if a derivative needs it
    std::array<Rows, 2> cotangent;
    Rows input_cotangent;

    Scalar* last_cotangent() { return cotangent[(activations.size() - 1) % 2].data(); }
  };

  template <Activation kKind>
  void forward_as(const Scalar* parameters);
  template <Activation kKind>
  void forward_tangents_as(const Scalar* parameters);
  template <Activation kKind, bool kTangents>
  void backward_as(const Scalar* parameters, const Scalar* transposed);
  void path_backward(const Scalar* parameters, Pass& pass);

  const NetworkShape* shape_;
  Pass values_, tangents_;
  Rows gradient_;  // Products::kLanesPerWeight summands for each parameter
};

/// Block size for the training of T*.
inline constexpr int kBlock = 256;
using WideBlock = NetworkBlock<float, kBlock>;
inline constexpr int kRow = WideBlock::kStride;

}  // namespace nlo::trainer
