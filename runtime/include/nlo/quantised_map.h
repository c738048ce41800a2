// SPDX-License-Identifier: MIT
// The inverse map T* in int16, for cores without an FPU. It needs half the flash.
//   q     = saturate((in - centre) gain)                inputs in Q15
//   x_hat = scale (integer mlp)(q) + L in
// Its inputs and outputs are float, as those of a LearnedMap; the latent recurrence stays in float.
// `nlo export --scalar int16` writes it. Its bits are the same on every target and for both arithmetic policies.
#pragma once

#include <cstdint>
#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/int16.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp.h"

namespace nlo::inline NLO_ISA {

/// A layer as generated headers write it: weights[o] is the row of neuron o. kShift scales its sums to the argument of
/// the activation.
template <int kIn, int kOut, int kShift>
struct QuantisedDense {
  std::int16_t weights[kOut][kIn];
  std::int32_t bias[kOut];
};

/// A layer in the layout of the kernels.
template <int kIn_, int kOut_, int kShift_>
struct PackedQuantisedDense {
  static constexpr int kIn = kIn_;
  static constexpr int kOut = kOut_;
  static constexpr int kShift = kShift_;
  static constexpr int kRows = kernels::int16::Blocks<kOut>::kRows;
  alignas(4) std::int16_t weights[2 * kernels::int16::kPairs<kIn> * kRows];
  std::int32_t bias[kRows];
};

template <int kIn, int kOut, int kShift>
constexpr auto pack(const QuantisedDense<kIn, kOut, kShift>& layer) {
  PackedQuantisedDense<kIn, kOut, kShift> packed{};
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) {
      packed.weights[kernels::int16::weight_position<kIn, kOut>(o, i)] = layer.weights[o][i];
    }
    packed.bias[o] = layer.bias[o];
  }
  return packed;
}

/// out = f(W in + b) in Q15. An odd number of outputs is followed by a zero. Not inlined, so that layers of equal size
/// share the code.
template <Activation kKind, int kIn, int kOut, int kShift>
__attribute__((noinline)) void quantised_layer(const PackedQuantisedDense<kIn, kOut, kShift>& layer,
                                               const std::int16_t* in, std::int16_t* out) {
  constexpr bool kPadded = PackedQuantisedDense<kIn, kOut, kShift>::kRows > kOut;
  if constexpr (kOut % 2 != 0) out[kOut] = 0;
#if defined(NLO_RISCV_INTEGERS)
  if constexpr (kernels::int16::kActivatesRows<kKind>) {
    std::int32_t sums[kOut];
    kernels::int16::add_block<kOut, kernels::int16::kPairs<kIn>>(layer.weights, in, layer.bias, sums);
    kernels::int16::activate_rows<kKind, kShift, kOut>(sums, out, kernels::int16::kTanhTable.data() + 256);
    return;
  }
#endif
  kernels::int16::layer<kIn, kOut>(layer.weights, layer.bias, in, [&](int o, std::int32_t sum) NLO_INLINE_LAMBDA {
    if (!kPadded || o < kOut) out[o] = kernels::int16::activated<kKind, kShift>(sum);
  });
}

/// A chain of layers. The result is the sums of the last one, without an activation.
template <Activation kKind, class... Layers>
struct QuantisedMlp;

template <Activation kKind, class Last>
struct QuantisedMlp<kKind, Last> {
  static constexpr int kLayers = 1;
  static constexpr int kIn = Last::kIn;
  static constexpr int kOut = Last::kOut;
  static constexpr int kWidest = 2 * kernels::int16::kPairs<kIn>;  ///< largest number of inputs of a layer, padded
  Last layer;

  /// Computes the sums, n_out, from the inputs in `ping`. Layers use the buffers `ping` and `pong` in turn.
  void run(std::int16_t* ping, std::int16_t*, std::int32_t* sums) const {
    kernels::int16::layer<kIn, kOut>(layer.weights, layer.bias, ping, [&](int o, std::int32_t sum) {
      if (o < kOut) sums[o] = sum;
    });
  }
};

template <Activation kKind, class First, class... Rest>
struct QuantisedMlp<kKind, First, Rest...> {
  using Tail = QuantisedMlp<kKind, Rest...>;
  static_assert(First::kOut == Tail::kIn, "each layer reads what the one before it writes");
  static constexpr int kLayers = 1 + Tail::kLayers;
  static constexpr int kIn = First::kIn;
  static constexpr int kOut = Tail::kOut;
  static constexpr int kOwnWidth = 2 * kernels::int16::kPairs<kIn>;
  static constexpr int kWidest = kOwnWidth > Tail::kWidest ? kOwnWidth : Tail::kWidest;
  First layer;
  Tail tail;

  void run(std::int16_t* ping, std::int16_t* pong, std::int32_t* sums) const {
    quantised_layer<kKind>(layer, ping, pong);
    tail.run(pong, ping, sums);
  }
};

template <Activation kKind, int kIn, int kOut, int kShift>
constexpr auto make_quantised_mlp(const QuantisedDense<kIn, kOut, kShift>& last) {
  return QuantisedMlp<kKind, PackedQuantisedDense<kIn, kOut, kShift>>{pack(last)};
}
/// Makes a QuantisedMlp from layers as generated headers write them, first to last.
template <Activation kKind, int kIn, int kOut, int kShift, class... Rest>
constexpr auto make_quantised_mlp(const QuantisedDense<kIn, kOut, kShift>& first, const Rest&... rest) {
  using Tail = decltype(make_quantised_mlp<kKind>(rest...));
  return [&]<class... Layers>(const QuantisedMlp<kKind, Layers...>& tail) {
    return QuantisedMlp<kKind, PackedQuantisedDense<kIn, kOut, kShift>, Layers...>{pack(first), tail};
  }(Tail{make_quantised_mlp<kKind>(rest...)});
}

/// T*: scales the inputs to Q15, evaluates the integer network, scales its sums to float, adds the linear path, and
/// falls back to its linear rows (FallbackRows) where the result is far from them.
template <class Mlp_, class LinearPath_ = NoLinearPath, class ClockProducts_ = NoClockProducts,
          class Fallback_ = NoFallback>
struct QuantisedMap {
  using Scalar = float;
  static constexpr int kReads = Mlp_::kIn;  ///< inputs and products
  static constexpr int kIn = kReads - ClockProducts_::kCount;
  static constexpr int kOut = Mlp_::kOut;
  static constexpr bool kHasLinearPath = !std::is_same_v<LinearPath_, NoLinearPath>;
  static constexpr bool kHasClockProducts = ClockProducts_::kCount > 0;
  float centre[kReads];
  float gain[kReads];  ///< 32767 / (half of the range of the input)
  Mlp_ mlp;
  float scale[kOut];  ///< factor from the sums of the last layer to x_hat
  [[no_unique_address]] LinearPath_ linear_path{};
  [[no_unique_address]] ClockProducts_ products{};
  [[no_unique_address]] Fallback_ fallback{};

  /// out = T*(in), n_out; in = [z; y] or z, n_in.
  template <Arithmetic = Arithmetic::kDeterministic>
  void evaluate(const float* in, float* out) const {
    if constexpr (kHasClockProducts) {
      float all[kReads];
      products.template append<kIn>(in, all);
      evaluate_all(all, out);
    } else {
      evaluate_all(in, out);
    }
  }

 private:
  /// in: inputs and products.
  void evaluate_all(const float* in, float* out) const {
    alignas(4) std::int16_t ping[Mlp_::kWidest];
    alignas(4) std::int16_t pong[Mlp_::kWidest];
    if constexpr (kReads % 2 != 0) ping[kReads] = 0;
    for (int i = 0; i < kReads; ++i) ping[i] = kernels::int16::quantised(in[i] - centre[i], gain[i]);
    std::int32_t sums[kOut];
    mlp.run(ping, pong, sums);
    for (int o = 0; o < kOut; ++o) {
      float total = rounded(scale[o] * static_cast<float>(sums[o]));
      if constexpr (kHasLinearPath) {
        for (int i = 0; i < kReads; ++i) {
          total = multiply_add<Arithmetic::kDeterministic>(linear_path.weights[o][i], in[i], total);
        }
      }
      out[o] = total;
    }
    if constexpr (Fallback_::kCount > 0) fallback.template correct<Arithmetic::kDeterministic>(in, out);
  }
};

}  // namespace nlo::inline NLO_ISA
