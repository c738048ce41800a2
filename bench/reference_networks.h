// SPDX-License-Identifier: MIT
// Straightforward code as a reference: the network of an observer as plain loops, and as products of fixed-size Eigen
// matrices. Benchmarks run it beside the runtime's kernels on the same weights.
#pragma once

#include <nlo/mlp.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "bench/random_model.h"

namespace nlo::bench {

/// Returns the layers of random_mlp() unchanged: a tuple of Dense.
template <int kIn, int kWidth, int kDepth, int kOut>
constexpr auto random_layers() {
  return []<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    return std::tuple{random_dense<kIn, kWidth>(1), random_dense<kWidth, kWidth>(kIndex + 2)...,
                      random_dense<kWidth, kOut>(1000)};
  }
  (std::make_index_sequence<kDepth - 1>{});
}

/// Row by row, with sequential multiply-adds and std::tanh.
template <Activation kKind, class... Layers>
class NaiveNetwork {
 public:
  explicit NaiveNetwork(const std::tuple<Layers...>& layers) : layers_(layers) {}

  void evaluate(const float* in, float* out) const { run<0>(in, out); }

 private:
  template <std::size_t kLayer>
  void run(const float* in, float* out) const {
    const auto& layer = std::get<kLayer>(layers_);
    if constexpr (kLayer + 1 == sizeof...(Layers)) {
      apply(layer, in, out, [](float v) { return v; });
    } else {
      float hidden[std::size(decltype(layer.bias){})];
      apply(layer, in, hidden, [](float v) { return kKind == Activation::kTanh ? std::tanh(v) : std::max(v, 0.0F); });
      run<kLayer + 1>(hidden, out);
    }
  }

  template <int kIn, int kOut, class Function>
  static void apply(const Dense<float, kIn, kOut>& layer, const float* in, float* out, Function function) {
    for (int o = 0; o < kOut; ++o) {
      float sum = layer.bias[o];
      for (int i = 0; i < kIn; ++i) sum += layer.weights[o][i] * in[i];
      out[o] = function(sum);
    }
  }

  std::tuple<Layers...> layers_;
};

/// Eigen's fixed-size product and its vectorised tanh. kOrder is the storage order of the weights.
template <Activation kKind, int kOrder, class... Layers>
class EigenNetwork {
 public:
  explicit EigenNetwork(const std::tuple<Layers...>& layers)
      : layers_(std::apply([](const auto&... layer) { return std::tuple{Layer<Layers>(layer)...}; }, layers)) {}

  void evaluate(const float* in, float* out) const { run<0>(in, out); }

 private:
  template <class Dense_>
  struct Layer;
  template <int kIn_, int kOut_>
  struct Layer<Dense<float, kIn_, kOut_>> {
    static constexpr int kIn = kIn_;
    static constexpr int kOut = kOut_;
    explicit Layer(const Dense<float, kIn, kOut>& dense)
        : weights(Eigen::Map<const Eigen::Matrix<float, kOut, kIn, Eigen::RowMajor>>(&dense.weights[0][0])),
          bias(dense.bias) {}
    Eigen::Matrix<float, kOut, kIn, kOrder> weights;
    Eigen::Matrix<float, kOut, 1> bias;
  };

  template <std::size_t kLayer>
  void run(const float* in, float* out) const {
    const auto& layer = std::get<kLayer>(layers_);
    using ThisLayer = std::remove_cvref_t<decltype(layer)>;
    const Eigen::Map<const Eigen::Matrix<float, ThisLayer::kIn, 1>> x(in);
    if constexpr (kLayer + 1 == sizeof...(Layers)) {
      Eigen::Map<Eigen::Matrix<float, ThisLayer::kOut, 1>>(out).noalias() = layer.weights * x + layer.bias;
    } else {
      Eigen::Matrix<float, ThisLayer::kOut, 1> hidden = layer.bias;
      hidden.noalias() += layer.weights * x;
      if constexpr (kKind == Activation::kTanh) {
        hidden = hidden.array().tanh();
      } else {
        hidden = hidden.array().max(0.0F);
      }
      run<kLayer + 1>(hidden.data(), out);
    }
  }

  std::tuple<Layer<Layers>...> layers_;
};

template <Activation kKind, class... Layers>
auto naive_network(const std::tuple<Layers...>& layers) {
  return NaiveNetwork<kKind, Layers...>(layers);
}
template <Activation kKind, int kOrder, class... Layers>
auto eigen_network(const std::tuple<Layers...>& layers) {
  return EigenNetwork<kKind, kOrder, Layers...>(layers);
}

}  // namespace nlo::bench
