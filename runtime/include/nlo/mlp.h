// SPDX-License-Identifier: MIT
// A learned map, T* first of all: a multilayer perceptron with an optional linear path beside it,
//   out = mlp(in) + L in,   mlp = affine o activation o affine o ... o affine,
// jvp.h has its derivative along a direction, mlp_batch.h many inputs at once.
// Layers are written one neuron per row (Dense) and packed, at compile time, into the kernels' layout (PackedDense).
#pragma once

#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo {

/// One layer as it is written: weights[o] is the row of neuron o. Weight is float, double, or of weight.h.
template <class Weight, int kIn, int kOut>
struct Dense {
  Weight weights[kOut][kIn];
  typename ComputesIn<Weight>::Type bias[kOut];
  constexpr Weight weight(int o, int i) const { return weights[o][i]; }
};

/// A layer as it is executed, from Dense or PanelDense. In each layout an output's weights are equally far apart.
template <template <class, int, int> class Written, class Weight, int kIn, int kOut>
constexpr PackedDense<Weight, kIn, kOut> pack(const Written<Weight, kIn, kOut>& layer) {
  using Packed = PackedDense<Weight, kIn, kOut>;
  if constexpr (std::is_same_v<Written<Weight, kIn, kOut>, Packed>) {
    return layer;
  } else {
    Packed packed{};
    for (int o = 0; o < kOut; ++o) {
      const int first = Packed::Layout::weight_position(o, 0);
      const int step = kIn > 1 ? Packed::Layout::weight_position(o, 1) - first : 1;
      for (int i = 0; i < kIn; ++i) packed.weights[first + i * step] = layer.weight(o, i);
      packed.bias[o] = layer.bias[o];
    }
    return packed;
  }
}

/// Values between two layers.
template <class Scalar, int kN>
struct LayerBuffer {
  static constexpr int kAlignment = kernels::kHasVectors ? 64 : 4;
  alignas(kAlignment) alignas(Scalar) Scalar values[kernels::padded(kN)];
};

/// The inputs of a network with zeros behind them where its kernel wants that: `in` itself, or a copy in `buffer`.
template <int kIn, class Scalar>
NLO_INLINE const Scalar* padded_inputs(const Scalar* in,
                                       LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1>& buffer) {
  if constexpr (kernels::kPadsInputs<kIn>) {
    for (int i = 0; i < kIn; ++i) buffer.values[i] = in[i];
    for (int i = kIn; i < kernels::padded(kIn); ++i) buffer.values[i] = Scalar(0);
    return buffer.values;
  } else {
    return in;
  }
}

/// A chain of layers; the last one is linear. Widths may differ from layer to layer. Without layers: its end.
template <Activation kKind, class... Layers>
struct Mlp {
  static constexpr int kLayers = 0, kIn = 0, kOut = 0, kHidden = 0;
  static constexpr int kWidest = 1;  // an array has one element at least
};

template <Activation kKind, class First, class... Rest>
struct Mlp<kKind, First, Rest...> {
  using Scalar = typename First::Scalar;
  using Tail = Mlp<kKind, Rest...>;
  static constexpr Activation kActivation = kKind;
  static constexpr int kLayers = 1 + Tail::kLayers;
  static constexpr int kIn = First::kIn;
  static constexpr int kOut = kLayers == 1 ? First::kOut : Tail::kOut;
  static constexpr int kWidest = kLayers > 1 && First::kOut > Tail::kWidest ? First::kOut : Tail::kWidest;  ///< hidden
  static constexpr int kHidden = kLayers == 2 ? First::kOut : Tail::kHidden;  ///< values of the last hidden layer
  static_assert(kLayers == 1 || First::kOut == Tail::kIn, "each layer reads what the one before it writes");
  First layer;
  [[no_unique_address]] Tail tail;

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    // Ping-pong buffers: one per layer would be a kilobyte of stack on a microcontroller.
    LayerBuffer<Scalar, kWidest> ping, pong;
    LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1> inputs;
    kernels::evaluate<kKind, kArithmetic>(*this, padded_inputs<kIn>(in, inputs), out, ping.values, pong.values);
  }
};

/// Mlp from layers as written (Dense or PanelDense), first to last.
template <Activation kKind>
constexpr Mlp<kKind> make_mlp() {
  return {};
}
template <Activation kKind, class First, class... Rest>
constexpr auto make_mlp(const First& first, const Rest&... rest) {
  return [&]<class... Layers>(const Mlp<kKind, Layers...>& tail) {
    return Mlp<kKind, decltype(pack(first)), Layers...>{pack(first), tail};
  }(make_mlp<kKind>(rest...));
}

/// The linear path beside a network: kOut x kIn, one row per output.
template <class Scalar, int kIn, int kOut>
struct LinearPath {
  Scalar weights[kOut][kIn];
};

/// No linear path.
struct NoLinearPath {};

/// No standard deviations of the errors (error_head.h).
struct NoErrorHead {};

/// A learned map: network plus linear path. Of T*, where the model knows how wrong it is, a second head too.
template <class Mlp_, class LinearPath_ = NoLinearPath, class ErrorHead_ = NoErrorHead>
struct LearnedMap {
  using Scalar = typename Mlp_::Scalar;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  static constexpr bool kHasLinearPath = !std::is_same_v<LinearPath_, NoLinearPath>;
  static constexpr bool kHasError = !std::is_same_v<ErrorHead_, NoErrorHead>;
  static_assert(!kHasLinearPath || std::is_same_v<LinearPath_, LinearPath<Scalar, kIn, kOut>> ||
                    std::is_same_v<LinearPath_, NoLinearPath>,
                "the linear path has the network's inputs and outputs");
  Mlp_ mlp;
  [[no_unique_address]] LinearPath_ linear_path{};
  [[no_unique_address]] ErrorHead_ error{};

  /// out (kOut) = map(in), in (kIn); for T* that is [z; y] or z. With log2_sigma (kOut): see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void evaluate(const Scalar* in, Scalar* out, Log2Sigma*... log2_sigma) const {
    if constexpr (sizeof...(Log2Sigma) == 0) {
      mlp.template evaluate<kArithmetic>(in, out);
    } else {
      error.template evaluate<kArithmetic>(mlp, in, out, log2_sigma...);
    }
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kIn; ++i) total = multiply_add<kArithmetic>(linear_path.weights[o][i], in[i], total);
        out[o] = total;
      }
    }
  }
};

/// Its name in headers of version 0.2.
template <class Mlp_, class LinearPath_ = NoLinearPath, class ErrorHead_ = NoErrorHead>
using InverseMap [[deprecated("it is called LearnedMap")]] = LearnedMap<Mlp_, LinearPath_, ErrorHead_>;

}  // namespace nlo
