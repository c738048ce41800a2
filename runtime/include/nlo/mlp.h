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
};

template <class Weight, int kIn, int kOut>
constexpr PackedDense<Weight, kIn, kOut> pack(const Dense<Weight, kIn, kOut>& layer) {
  PackedDense<Weight, kIn, kOut> packed{};
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) {
      packed.weights[PackedDense<Weight, kIn, kOut>::Layout::weight_position(o, i)] = layer.weights[o][i];
    }
    packed.bias[o] = layer.bias[o];
  }
  return packed;
}
template <class Weight, int kIn, int kOut>
constexpr PackedDense<Weight, kIn, kOut> pack(const PanelDense<Weight, kIn, kOut>& layer) {
  if constexpr (kernels::kHasVectors) {
    return layer;
  } else {
    PackedDense<Weight, kIn, kOut> packed{};
    for (int o = 0; o < kOut; ++o) {
      for (int i = 0; i < kIn; ++i) {
        packed.weights[PackedDense<Weight, kIn, kOut>::Layout::weight_position(o, i)] =
            layer.weights[kernels::Panels<kIn, kOut>::weight_position(o, i)];
      }
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

/// A chain of layers; the last one is linear. Widths may differ from layer to layer.
template <Activation kKind, class... Layers>
struct Mlp;

template <Activation kKind, class Last>
struct Mlp<kKind, Last> {
  using Scalar = typename Last::Scalar;
  static constexpr int kLayers = 1;
  static constexpr int kIn = Last::kIn;
  static constexpr int kOut = Last::kOut;
  static constexpr int kWidest = 1;  ///< hidden layer; an array has one element at least
  static constexpr int kHidden = 0;
  Last layer;

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1> inputs;
    kernels::layer<kKind, kArithmetic, true, kIn, kOut>(layer.weights, layer.bias, padded_inputs<kIn>(in, inputs), out);
  }
};

template <Activation kKind, class First, class... Rest>
struct Mlp<kKind, First, Rest...> {
  using Scalar = typename First::Scalar;
  using Tail = Mlp<kKind, Rest...>;
  static_assert(First::kOut == Tail::kIn, "each layer reads what the one before it writes");
  static constexpr int kLayers = 1 + Tail::kLayers;
  static constexpr int kIn = First::kIn;
  static constexpr int kOut = Tail::kOut;
  static constexpr int kWidest = First::kOut > Tail::kWidest ? First::kOut : Tail::kWidest;
  static constexpr int kHidden = kLayers == 2 ? First::kOut : Tail::kHidden;  ///< values of the last hidden layer
  First layer;
  Tail tail;

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    // Ping-pong buffers: one per layer would be a kilobyte of stack on a microcontroller.
    LayerBuffer<Scalar, kWidest> ping, pong;
    LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1> inputs;
    kernels::evaluate<kKind, kArithmetic>(*this, padded_inputs<kIn>(in, inputs), out, ping.values, pong.values);
  }

  /// The same; `hidden`, a LayerBuffer of kWidest, begins with the last hidden layer (kHidden) then, activated.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out, Scalar* hidden) const {
    LayerBuffer<Scalar, kWidest> other;
    LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1> inputs;
    constexpr bool kPing = kLayers % 2 == 0;  // layers alternate, and the first one writes to ping
    kernels::evaluate<kKind, kArithmetic>(*this, padded_inputs<kIn>(in, inputs), out, kPing ? hidden : other.values,
                                          kPing ? other.values : hidden);
  }
};

/// Mlp from layers as written (Dense or PanelDense), first to last.
template <Activation kKind, class Last>
constexpr auto make_mlp(const Last& last) {
  return Mlp<kKind, decltype(pack(last))>{pack(last)};
}
template <Activation kKind, class First, class... Rest>
constexpr auto make_mlp(const First& first, const Rest&... rest) {
  using Tail = decltype(make_mlp<kKind>(rest...));
  return [&]<class... Layers>(const Mlp<kKind, Layers...>& tail) {
    return Mlp<kKind, decltype(pack(first)), Layers...>{pack(first), tail};
  }(Tail{make_mlp<kKind>(rest...)});
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
struct InverseMap {
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

  /// out (kOut) = map(in), in (kIn); for T* that is [z; y] or z.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    mlp.template evaluate<kArithmetic>(in, out);
    add_linear_path<kArithmetic>(in, out);
  }

  /// The same, and log2 of the standard deviation of each output's error (kOut), not held within its range yet.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out, Scalar* log2_sigma) const requires kHasError {
    static_assert(ErrorHead_::kWidth == Mlp_::kHidden && ErrorHead_::kNx == kOut, "it reads the last hidden layer");
    constexpr int kRoom = 2 * Mlp_::kHidden > Mlp_::kWidest ? 2 * Mlp_::kHidden : Mlp_::kWidest;
    LayerBuffer<Scalar, kRoom> hidden;
    mlp.template evaluate<kArithmetic>(in, out, hidden.values);
    add_linear_path<kArithmetic>(in, out);
    error.template evaluate<kArithmetic>(hidden.values, log2_sigma);
  }

 private:
  template <Arithmetic kArithmetic>
  void add_linear_path(const Scalar* in, Scalar* out) const {
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kIn; ++i) total = multiply_add<kArithmetic>(linear_path.weights[o][i], in[i], total);
        out[o] = total;
      }
    }
  }
};

/// The same for a map that is not an inverse: T, F, g_hat.
template <class Mlp_, class LinearPath_ = NoLinearPath>
using LearnedMap = InverseMap<Mlp_, LinearPath_>;

}  // namespace nlo
