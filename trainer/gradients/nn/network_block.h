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
  /// Distance between rows: no power of two in wide blocks, so that rows spread over the cache's sets.
  static constexpr int kStride = kColumns >= 128 ? kColumns + 16 : kColumns;
  static_assert(kColumns % kWidth == 0);

  /// with_tangents: also keep room for the passes with tangents.
  explicit NetworkBlock(const NetworkShape& shape, bool with_tangents = false);

  /// Inputs u, n_in rows; to be filled by the caller. Columns past the samples must be finite.
  Scalar* input() { return values_.activations[0].data(); }
  /// Outputs n, n_out rows.
  Scalar* output() { return values_.activations.back().data(); }
  /// Cotangent of the outputs, n_out rows; to be filled by the caller, zero past the samples. Overwritten by
  /// backward().
  Scalar* output_cotangent() { return values_.last_cotangent(); }
  /// Cotangent of the inputs, n_in rows, after backward().
  const Scalar* input_cotangent() const { return values_.input_cotangent.data(); }

  /// Tangents of the inputs and outputs, and their cotangents.
  Scalar* input_tangent() { return tangents_.activations[0].data(); }
  Scalar* output_tangent() { return tangents_.activations.back().data(); }
  Scalar* output_tangent_cotangent() { return tangents_.last_cotangent(); }
  const Scalar* input_tangent_cotangent() const { return tangents_.input_cotangent.data(); }

  void forward(const Scalar* parameters);
  /// After forward(): output_tangent() = J input_tangent().
  void forward_tangents(const Scalar* parameters);

  /// Adds to the gradient. `transposed` is made once per step by transpose_weights().
  void backward(const Scalar* parameters, const Scalar* transposed);
  /// Backward pass for a loss of outputs and their tangents. Both cotangents must be filled.
  void backward_tangents(const Scalar* parameters, const Scalar* transposed);

  void clear_gradient();
  /// Writes the gradient (n parameters).
  void gradient(Scalar* out) const;

 private:
  using Rows = AlignedVector<Scalar>;
  struct Pass {
    std::vector<Rows> activations;      // a_0 ... a_L, (width x kStride) each
    std::vector<Rows> pre_activations;  // v_l, only where a derivative needs it
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
  Rows gradient_;  // Products::kLanesPerWeight summands of each parameter's
};

/// The block that T* is trained by.
inline constexpr int kBlock = 256;
using WideBlock = NetworkBlock<float, kBlock>;
inline constexpr int kRow = WideBlock::kStride;

}  // namespace nlo::trainer
