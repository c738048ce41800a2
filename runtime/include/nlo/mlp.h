// SPDX-License-Identifier: MIT
// A learned map, such as T*: a multilayer perceptron with an optional linear path beside it,
//   out = mlp(in) + L in,   mlp = affine o activation o affine o ... o affine
// T* may also read products of its inputs with clocks (ClockProducts); then `in` stands for [in; products].
// jvp.h has its derivative along a direction; mlp_batch.h evaluates it for many inputs at once.
// Generated headers write layers with one neuron per row (Dense). At compile time they are packed into the layout of
// the kernels (PackedDense).
#pragma once

#include <cstdint>
#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// A layer as generated headers write it: weights[o] is the row of neuron o. Weight: float, double, or a type of
/// weight.h.
template <class Weight, int kIn, int kOut>
struct Dense {
  Weight weights[kOut][kIn];
  typename ComputesIn<Weight>::Type bias[kOut];
  constexpr Weight weight(int o, int i) const { return weights[o][i]; }
};

/// Packs a Dense or PanelDense layer into the layout of the kernels. In every layout the weights of one output are
/// equally spaced.
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

/// Output values of a layer, padded and aligned for the kernels.
template <class Scalar, int kN>
struct LayerBuffer {
  static constexpr int kAlignment = kernels::kHasVectors ? 64 : 4;
  alignas(kAlignment) alignas(Scalar) Scalar values[kernels::padded(kN)];
};

/// Returns the inputs of a network, padded with zeros if its kernel needs that: `in` itself, or a copy in `buffer`.
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

/// A chain of layers. The last one has no activation. The chain without layers is the end of the recursion.
template <Activation kKind, class... Layers>
struct Mlp {
  static constexpr int kLayers = 0, kIn = 0, kOut = 0, kHidden = 0;
  static constexpr int kWidest = 1;  // an array needs at least one element
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
    // Two buffers in turn: one buffer per layer would take a kilobyte of stack.
    LayerBuffer<Scalar, kWidest> ping, pong;
    LayerBuffer<Scalar, kernels::kPadsInputs<kIn> ? kIn : 1> inputs;
    kernels::evaluate<kKind, kArithmetic>(*this, padded_inputs<kIn>(in, inputs), out, ping.values, pong.values);
  }
};

/// Makes an Mlp from layers as generated headers write them (Dense or PanelDense), first to last.
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

/// Stands for a map without a linear path.
struct NoLinearPath {};

/// Stands for a map without an error head (error_head.h).
struct NoErrorHead {};

/// Products in[factor] in[clock], which T* reads after its inputs. A clock is a latent state exp(-t / tau), which falls
/// from 1 to 0 after a start. The products let T* depend on the time since the start for as long as z depends on it.
template <int kCount_>
struct ClockProducts {
  static constexpr int kCount = kCount_;
  std::uint16_t factors[kCount][2];  ///< {factor, clock}: indices of inputs

  /// Writes [in; products] of kTogether inputs at once: `in` is n_in x kTogether, `all` has kCount rows more.
  template <int kIn, int kTogether = 1, class Scalar>
  constexpr void append(const Scalar* in, Scalar* all) const {
    for (int i = 0; i < kIn * kTogether; ++i) all[i] = in[i];
    for (int p = 0; p < kCount; ++p) {
      const Scalar* factor = in + factors[p][0] * kTogether;
      const Scalar* clock = in + factors[p][1] * kTogether;
      for (int n = 0; n < kTogether; ++n) all[(kIn + p) * kTogether + n] = factor[n] * clock[n];
    }
  }
};

/// Stands for a map that reads no products.
struct NoClockProducts {
  static constexpr int kCount = 0;
};

/// Returns row + w (estimate - row) with w = 1 / (1 + ((estimate - row) per_reach)^2). The result is within
/// 1 / (2 per_reach) of the row. If the square overflows, w is 0.
template <Arithmetic kArithmetic, class Scalar>
NLO_INLINE Scalar fall_back(Scalar estimate, Scalar row, Scalar per_reach) {
  const Scalar apart = estimate - row, ratio = apart * per_reach;
  return row + apart / multiply_add<kArithmetic>(ratio, ratio, Scalar(1));
}

/// Linear rows for some outputs of T*. If the network's output is far from its row, fall_back() follows the row.
template <class Scalar, int kIn, int kCount_>
struct FallbackRows {
  static constexpr int kCount = kCount_;
  std::uint16_t outputs[kCount];  ///< output of each row
  Scalar weights[kCount][kIn];
  Scalar offset[kCount];
  Scalar per_reach[kCount];  ///< 1 / distance from the row at which w is 1/2

  /// Corrects kTogether estimates at once: `in` is n_in x kTogether, `out` n_out x kTogether.
  template <Arithmetic kArithmetic, int kTogether = 1>
  NLO_INLINE void correct(const Scalar* in, Scalar* out) const {
    for (int f = 0; f < kCount; ++f) {
      Scalar rows[kTogether];
      for (int n = 0; n < kTogether; ++n) rows[n] = offset[f];
      for (int i = 0; i < kIn; ++i)
        for (int n = 0; n < kTogether; ++n)
          rows[n] = multiply_add<kArithmetic>(weights[f][i], in[i * kTogether + n], rows[n]);
      Scalar* estimates = out + outputs[f] * kTogether;
      for (int n = 0; n < kTogether; ++n) estimates[n] = fall_back<kArithmetic>(estimates[n], rows[n], per_reach[f]);
    }
  }
};

/// Stands for a map whose outputs do not fall back.
struct NoFallback {
  static constexpr int kCount = 0;
};

/// A learned map: network, optional linear path, and for T* an optional error head, optional products with clocks and
/// an optional fallback.
template <class Mlp_, class LinearPath_ = NoLinearPath, class ErrorHead_ = NoErrorHead,
          class ClockProducts_ = NoClockProducts, class Fallback_ = NoFallback>
struct LearnedMap {
  using Scalar = typename Mlp_::Scalar;
  static constexpr int kReads = Mlp_::kIn;  ///< inputs and products
  static constexpr int kIn = kReads - ClockProducts_::kCount;
  static constexpr int kOut = Mlp_::kOut;
  static constexpr bool kHasLinearPath = !std::is_same_v<LinearPath_, NoLinearPath>;
  static constexpr bool kHasError = !std::is_same_v<ErrorHead_, NoErrorHead>;
  static constexpr bool kHasClockProducts = ClockProducts_::kCount > 0;
  static constexpr bool kHasFallback = Fallback_::kCount > 0;
  static_assert(!kHasLinearPath || std::is_same_v<LinearPath_, LinearPath<Scalar, kReads, kOut>> ||
                    std::is_same_v<LinearPath_, NoLinearPath>,
                "the linear path has the network's inputs and outputs");
  Mlp_ mlp;
  [[no_unique_address]] LinearPath_ linear_path{};
  [[no_unique_address]] ErrorHead_ error{};
  [[no_unique_address]] ClockProducts_ products{};
  [[no_unique_address]] Fallback_ fallback{};

  /// Computes out = map(in), n_out. in: n_in values, for T* [z; y] or z. log2_sigma: n_out values, see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void evaluate(const Scalar* in, Scalar* out, Log2Sigma*... log2_sigma) const {
    if constexpr (kHasClockProducts) {
      Scalar all[kReads];
      products.template append<kIn>(in, all);
      evaluate_all<kArithmetic>(all, out, log2_sigma...);
    } else {
      evaluate_all<kArithmetic>(in, out, log2_sigma...);
    }
  }

 private:
  /// Computes the map. in: kReads values, the inputs and the products.
  template <Arithmetic kArithmetic, class... Log2Sigma>
  void evaluate_all(const Scalar* in, Scalar* out, Log2Sigma*... log2_sigma) const {
    if constexpr (sizeof...(Log2Sigma) == 0) {
      mlp.template evaluate<kArithmetic>(in, out);
    } else {
      error.template evaluate<kArithmetic>(mlp, in, out, log2_sigma...);
    }
    if constexpr (kHasLinearPath) {
      for (int o = 0; o < kOut; ++o) {
        Scalar total = out[o];
        for (int i = 0; i < kReads; ++i) total = multiply_add<kArithmetic>(linear_path.weights[o][i], in[i], total);
        out[o] = total;
      }
    }
    if constexpr (kHasFallback) fallback.template correct<kArithmetic>(in, out);
  }
};

/// Name of LearnedMap in headers of version 0.2.
template <class Mlp_, class LinearPath_ = NoLinearPath, class ErrorHead_ = NoErrorHead>
using InverseMap [[deprecated("it is called LearnedMap")]] = LearnedMap<Mlp_, LinearPath_, ErrorHead_>;

}  // namespace nlo::inline NLO_ISA
