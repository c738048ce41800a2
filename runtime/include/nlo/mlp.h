// SPDX-License-Identifier: MIT
// A learned map, T* first of all: a multilayer perceptron with an optional linear path beside it,
//   out = mlp(in) + L in,   mlp = affine o activation o affine o ... o affine,
// and its derivative along a direction (jvp).
// Layers are written one neuron per row (Dense) and packed, at compile time, into the kernels' layout (PackedDense).
#pragma once

#include <type_traits>

#include "nlo/activation.h"
#include "nlo/arithmetic.h"
#include "nlo/kernels/dense.h"
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
      packed.weights[kernels::weight_position<Scalar, kIn, kOut>(o, i)] = layer.weights[o][i];
    }
    packed.bias[o] = layer.bias[o];
  }
  return packed;
}

/// W d, the derivative of a layer along d: the layer without its bias.
template <Activation kKind, class Scalar, int kIn, int kOut>
NLO_INLINE void dense_tangent(const PackedDense<Scalar, kIn, kOut>& layer, const Scalar* direction, Scalar* out) {
  const Scalar no_bias[kOut]{};
  kernels::layer<kKind, Arithmetic::kFast, true, kIn, kOut>(layer.weights, no_bias, direction, out);
}

/// Hidden values and their tangents on the way through a network.
template <class Scalar, int kWidest>
struct JvpBuffer {
  alignas(Scalar) alignas(simd::kVectorBytes) Scalar value[kWidest];
  alignas(Scalar) alignas(simd::kVectorBytes) Scalar tangent[kWidest];
};

/// A chain of layers; the last one is linear. Widths may differ from layer to layer.
template <Activation kKind, class... Layers>
struct Mlp;

template <Activation kKind, class Last>
struct Mlp<kKind, Last> {
  using Scalar = typename Last::Scalar;
  static constexpr int kIn = Last::kIn;
  static constexpr int kOut = Last::kOut;
  static constexpr int kWidest = 1;  ///< hidden layer; an array has one element at least
  Last layer;

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    run<kArithmetic>(in, out, nullptr, nullptr);
  }

  template <Arithmetic kArithmetic>
  NLO_INLINE void run(const Scalar* in, Scalar* out, Scalar*, Scalar*) const {
    kernels::layer<kKind, kArithmetic, true, kIn, kOut>(layer.weights, layer.bias, in, out);
  }

  void jvp(const Scalar*, const Scalar* direction, Scalar* out) const { dense_tangent<kKind>(layer, direction, out); }

  template <class Buffer>
  NLO_INLINE void run_jvp(const Scalar* in, const Scalar* direction, Scalar* out, Buffer&, Buffer&) const {
    jvp(in, direction, out);
  }
};

template <Activation kKind, class First, class... Rest>
struct Mlp<kKind, First, Rest...> {
  using Scalar = typename First::Scalar;
  using Tail = Mlp<kKind, Rest...>;
  static_assert(First::kOut == Tail::kIn, "each layer reads what the one before it writes");
  static constexpr int kIn = First::kIn;
  static constexpr int kOut = Tail::kOut;
  static constexpr int kWidest = First::kOut > Tail::kWidest ? First::kOut : Tail::kWidest;
  First layer;
  Tail tail;

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    // Two buffers, taken by turns: one per layer would be a kilobyte of stack on a microcontroller.
    alignas(Scalar) alignas(simd::kVectorBytes) Scalar here[kWidest];
    alignas(Scalar) alignas(simd::kVectorBytes) Scalar there[kWidest];
    run<kArithmetic>(in, out, here, there);
  }

  /// Writes hidden values to `here`; the layers behind use `there` and `here` by turns.
  template <Arithmetic kArithmetic>
  NLO_INLINE void run(const Scalar* in, Scalar* out, Scalar* here, Scalar* there) const {
    kernels::layer<kKind, kArithmetic, false, kIn, First::kOut>(layer.weights, layer.bias, in, here);
    tail.template run<kArithmetic>(here, out, there, here);
  }

  void jvp(const Scalar* in, const Scalar* direction, Scalar* out) const {
    JvpBuffer<Scalar, kWidest> here, there;
    run_jvp(in, direction, out, here, there);
  }

  template <class Buffer>
  NLO_INLINE void run_jvp(const Scalar* in, const Scalar* direction, Scalar* out, Buffer& here, Buffer& there) const {
    kernels::layer<kKind, Arithmetic::kFast, true, kIn, First::kOut>(layer.weights, layer.bias, in, here.value);
    dense_tangent<kKind>(layer, direction, here.tangent);
    for (int o = 0; o < First::kOut; ++o) {
      const Scalar v = here.value[o];
      here.value[o] = activate<kKind>(v);
      here.tangent[o] *= activation_slope<kKind>(v, here.value[o]);
    }
    tail.run_jvp(here.value, here.tangent, out, there, here);
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

/// A learned map: network plus linear path.
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

  /// out (kOut) = map(in), in (kIn); for T* that is [z; y] or z.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void evaluate(const Scalar* in, Scalar* out) const {
    mlp.template evaluate<kArithmetic>(in, out);
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kIn; ++i) total = multiply_add<kArithmetic>(linear_path.weights[o][i], in[i], total);
        out[o] = total;
      }
    }
  }

  /// out (kOut) = d map/d in (in) direction, by the forward mode: a value and a tangent go through the layers side by
  /// side. Twice the multiply-adds of evaluate(), and four buffers of the widest layer's size, whatever the depth.
  void jvp(const Scalar* in, const Scalar* direction, Scalar* out) const {
    mlp.jvp(in, direction, out);
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kIn; ++i) total += linear_path.weights[o][i] * direction[i];
        out[o] = total;
      }
    }
  }
};

/// The same for a map that is not an inverse: T, F, g_hat.
template <class Mlp_, class LinearPath_ = NoLinearPath>
using LearnedMap = InverseMap<Mlp_, LinearPath_>;

}  // namespace nlo
