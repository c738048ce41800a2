// SPDX-License-Identifier: MIT
// Straightforward code for a microcontroller as a reference: the network as plain loops, and as products of fixed-size
// Eigen matrices. The weights stay in flash unchanged; reference_networks.h copies them.
#pragma once

#include <nlo/mlp.h>

#include <Eigen/Core>
#include <cmath>
#include <tuple>
#include <utility>

#include "bench/reference_networks.h"

namespace nlo::bench {

template <Activation kKind>
float usual_activation(float v) {
  return kKind == Activation::kTanh ? std::tanh(v) : (v > 0.0F ? v : 0.0F);
}

template <Activation kKind, int kLayer = 0, class... Layers>
void naive_estimate(const std::tuple<Layers...>& layers, const float* in, float* out) {
  const auto& layer = std::get<kLayer>(layers);
  constexpr int kOut = static_cast<int>(std::extent_v<decltype(layer.bias)>);
  constexpr int kIn = static_cast<int>(std::extent_v<std::remove_reference_t<decltype(layer.weights)>, 1>);
  constexpr bool kLast = kLayer + 1 == sizeof...(Layers);
  float result[kOut];
  for (int o = 0; o < kOut; ++o) {
    float sum = layer.bias[o];
    for (int i = 0; i < kIn; ++i) sum += layer.weights[o][i] * in[i];
    result[o] = kLast ? sum : usual_activation<kKind>(sum);
  }
  if constexpr (kLast) {
    for (int o = 0; o < kOut; ++o) out[o] = result[o];
  } else {
    naive_estimate<kKind, kLayer + 1>(layers, result, out);
  }
}

template <Activation kKind, int kLayer = 0, class... Layers>
void eigen_estimate(const std::tuple<Layers...>& layers, const float* in, float* out) {
  const auto& layer = std::get<kLayer>(layers);
  constexpr int kOut = static_cast<int>(std::extent_v<decltype(layer.bias)>);
  constexpr int kIn = static_cast<int>(std::extent_v<std::remove_reference_t<decltype(layer.weights)>, 1>);
  using Eigen::Map;
  const Map<const Eigen::Matrix<float, kOut, kIn, Eigen::RowMajor>> weights(&layer.weights[0][0]);
  Eigen::Matrix<float, kOut, 1> result = Map<const Eigen::Matrix<float, kOut, 1>>(layer.bias);
  result.noalias() += weights * Map<const Eigen::Matrix<float, kIn, 1>>(in);
  if constexpr (kLayer + 1 == sizeof...(Layers)) {
    for (int o = 0; o < kOut; ++o) out[o] = result[o];
  } else {
    if constexpr (kKind == Activation::kTanh) {
      result = result.array().tanh();
    } else {
      result = result.array().max(0.0F);
    }
    eigen_estimate<kKind, kLayer + 1>(layers, result.data(), out);
  }
}

}  // namespace nlo::bench
