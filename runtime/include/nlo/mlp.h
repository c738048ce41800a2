// SPDX-License-Identifier: MIT
// The inverse map T*: a multilayer perceptron with an optional linear path beside it,
//   x_hat = mlp(in) + L in,   mlp = affine o activation o affine o ... o affine.
// Layers are written one neuron per row (Dense) and packed, at compile time, into the kernels' layout (PackedDense).
#pragma once

#include <type_traits>

#include "nlo/activation.h"
#include "nlo/kernels/generic.h"
#include "nlo/vector.h"

namespace nlo {

/// One layer as it is written: weights[o] is the row of neuron o.
template <class Scalar, int kIn, int kOut>
struct Dense {
  Scalar weights[kOut][kIn];
  Scalar bias[kOut];
};

/// One layer as it is executed.
template <class Scalar_, int kIn_, int kOut_>
struct PackedDense {
  using Scalar = Scalar_;
  static constexpr int kIn = kIn_;
  static constexpr int kOut = kOut_;
  Scalar weights[kIn * kOut];
  Scalar bias[kOut];
};

template <class Scalar, int kIn, int kOut>
constexpr PackedDense<Scalar, kIn, kOut> pack(const Dense<Scalar, kIn, kOut>& layer) {
  PackedDense<Scalar, kIn, kOut> packed{};
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) {
      packed.weights[kernels::kByColumns<kIn, kOut> ? i * kOut + o : o * kIn + i] = layer.weights[o][i];
    }
    packed.bias[o] = layer.bias[o];
  }
  return packed;
}

/// A chain of layers; the last one is linear. Widths may differ from layer to layer.
template <Activation kKind, class... Layers>
struct Mlp;

template <Activation kKind, class Last>
struct Mlp<kKind, Last> {
  using Scalar = typename Last::Scalar;
  static constexpr int kIn = Last::kIn;
  static constexpr int kOut = Last::kOut;
  Last layer;

  void evaluate(const Scalar* in, Scalar* out) const {
    kernels::dense<Scalar, kIn, kOut>(layer.weights, layer.bias, in, out, kernels::Identity{});
  }
};

template <Activation kKind, class First, class... Rest>
struct Mlp<kKind, First, Rest...> {
  using Scalar = typename First::Scalar;
  using Tail = Mlp<kKind, Rest...>;
  static_assert(First::kOut == Tail::kIn, "each layer reads what the one before it writes");
  static constexpr int kIn = First::kIn;
  static constexpr int kOut = Tail::kOut;
  First layer;
  Tail tail;

  void evaluate(const Scalar* in, Scalar* out) const {
    Scalar hidden[First::kOut];
    kernels::dense<Scalar, kIn, First::kOut>(layer.weights, layer.bias, in, hidden, kernels::Activate<kKind>{});
    tail.evaluate(hidden, out);
  }
};

/// Mlp from layers as written, first to last.
template <Activation kKind, class Scalar, int kIn, int kOut>
constexpr auto make_mlp(const Dense<Scalar, kIn, kOut>& last) {
  return Mlp<kKind, PackedDense<Scalar, kIn, kOut>>{pack(last)};
}
template <Activation kKind, class Scalar, int kIn, int kOut, class... Rest>
constexpr auto make_mlp(const Dense<Scalar, kIn, kOut>& first, const Rest&... rest) {
  using Tail = decltype(make_mlp<kKind>(rest...));
  return [&]<class... Layers>(const Mlp<kKind, Layers...>& tail) {
    return Mlp<kKind, PackedDense<Scalar, kIn, kOut>, Layers...>{pack(first), tail};
  }(Tail{make_mlp<kKind>(rest...)});
}

/// The linear path beside a network: kOut x kIn, one row per output.
template <class Scalar, int kIn, int kOut>
struct LinearPath {
  Scalar weights[kOut][kIn];
};

/// No linear path.
struct NoLinearPath {};

/// T*: network plus linear path.
template <class Mlp_, class LinearPath_ = NoLinearPath>
struct InverseMap {
  using Scalar = typename Mlp_::Scalar;
  static constexpr int kIn = Mlp_::kIn;
  static constexpr int kOut = Mlp_::kOut;
  static constexpr bool kHasLinearPath = !std::is_same_v<LinearPath_, NoLinearPath>;
  static_assert(!kHasLinearPath || std::is_same_v<LinearPath_, LinearPath<Scalar, kIn, kOut>> ||
                    std::is_same_v<LinearPath_, NoLinearPath>,
                "the linear path has the network's inputs and outputs");
  Mlp_ mlp;
  [[no_unique_address]] LinearPath_ linear_path{};

  /// out (kOut) = T*(in), in (kIn) = [z; y] or z.
  void evaluate(const Scalar* in, Scalar* out) const {
    mlp.evaluate(in, out);
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kIn; ++i) total += linear_path.weights[o][i] * in[i];
        out[o] = total;
      }
    }
  }
};

}  // namespace nlo
