// SPDX-License-Identifier: MIT
// The derivative of a learned map along a direction, in forward mode: value and tangent pass through the layers
// together. This takes twice the multiply-adds of evaluate() and four buffers of the size of the widest layer.
#pragma once

#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/mlp.h"

namespace nlo::inline NLO_ISA {

/// Values of a hidden layer and their tangents.
template <class Scalar, int kWidest>
struct JvpBuffer {
  LayerBuffer<Scalar, kWidest> value, tangent;
};

namespace kernels {

#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/tangent.inc"
#undef NLO_CODE

/// Calls network_jvp() for the best instruction set of the CPU, like evaluate() of dense.h.
template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar, class Buffer>
NLO_INLINE void jvp(const Network& net, const Scalar* in, const Scalar* direction, Scalar* out, Buffer& ping,
                    Buffer& pong) {
#if defined(NLO_DISPATCHES)
  if (x86::dispatched([&] { x86::jvp_one_load<kKind, kArithmetic>(net, in, direction, out, ping, pong); },
                      [&] { x86::jvp_avx512<kKind, kArithmetic>(net, in, direction, out, ping, pong); },
                      [&] { x86::jvp_avx2<kKind, kArithmetic>(net, in, direction, out, ping, pong); }))
    return;
#endif
  network_jvp<kKind, kArithmetic>(net, in, direction, out, ping, pong);
}

}  // namespace kernels

using kernels::activation_slope;

/// out = (d mlp / d in)(in) direction, n_out; direction: n_in.
template <Arithmetic kArithmetic = Arithmetic::kFast, Activation kKind, class... Layers>
void jvp(const Mlp<kKind, Layers...>& mlp, const typename Mlp<kKind, Layers...>::Scalar* in,
         const typename Mlp<kKind, Layers...>::Scalar* direction, typename Mlp<kKind, Layers...>::Scalar* out) {
  using Net = Mlp<kKind, Layers...>;
  using Scalar = typename Net::Scalar;
  JvpBuffer<Scalar, Net::kWidest> ping, pong;
  LayerBuffer<Scalar, kernels::kPadsInputs<Net::kIn> ? Net::kIn : 1> inputs, directions;
  if constexpr (Net::kLayers > 1) in = padded_inputs<Net::kIn>(in, inputs);  // a network of one layer does not read it
  kernels::jvp<kKind, kArithmetic>(mlp, in, padded_inputs<Net::kIn>(direction, directions), out, ping, pong);
}

/// out = (d map / d in)(in) direction, n_out; direction: n_in.
template <Arithmetic kArithmetic = Arithmetic::kFast, class Net, class LinearPath, class ErrorHead>
void jvp(const LearnedMap<Net, LinearPath, ErrorHead>& map, const typename Net::Scalar* in,
         const typename Net::Scalar* direction, typename Net::Scalar* out) {
  jvp<kArithmetic>(map.mlp, in, direction, out);
  if constexpr (LearnedMap<Net, LinearPath, ErrorHead>::kHasLinearPath) {
    for (int o = 0; o < Net::kOut; ++o) {
      typename Net::Scalar total = out[o];
      for (int i = 0; i < Net::kIn; ++i)
        total = multiply_add<kArithmetic>(map.linear_path.weights[o][i], direction[i], total);
      out[o] = total;
    }
  }
}

}  // namespace nlo::inline NLO_ISA
