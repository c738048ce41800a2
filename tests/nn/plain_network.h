// SPDX-License-Identifier: MIT
// Reference for the blocked passes of trainer/gradients/nn: the network of T*, one sample at a time, in double, with
// the activations of the C++ library.
#pragma once

#include <vector>

#include "codegen/model/activations.h"
#include "trainer/gradients/nn/network_shape.h"

namespace nlo::trainer::testing {

using Doubles = std::vector<double>;

inline double plain_activation(Activation kind, double v) {
  return codegen::activation_row(kind).value(v);
}

inline double plain_slope(Activation kind, double v) {
  return codegen::activation_row(kind).slope(v);
}

struct PlainPass {
  Doubles output;
  Doubles input_cotangent;
};

/// Evaluates n = network(u). With a cotangent, also adds dl/dp to `gradient` and returns dl/du.
inline PlainPass plain_pass(const NetworkShape& shape, const Doubles& p, const Doubles& u,
                            const Doubles& cotangent = {}, Doubles* gradient = nullptr) {
  const auto at = [](int offset, int row, int columns, int column) {
    return static_cast<std::size_t>(offset + row * columns + column);
  };
  std::vector<Doubles> activations{u};
  std::vector<Doubles> pre_activations;
  for (std::size_t l = 0; l < shape.layers.size(); ++l) {
    const LayerView& layer = shape.layers[l];
    Doubles v;
    Doubles a;
    for (int o = 0; o < layer.out; ++o) {
      double sum = p[static_cast<std::size_t>(layer.bias + o)];
      for (int i = 0; i < layer.in; ++i) {
        sum += p[at(layer.weights, o, layer.in, i)] * activations[l][static_cast<std::size_t>(i)];
      }
      v.push_back(sum);
      a.push_back(l + 1 < shape.layers.size() ? plain_activation(shape.activation, sum) : sum);
    }
    pre_activations.push_back(v);
    activations.push_back(a);
  }
  PlainPass pass{activations.back(), Doubles(u.size(), 0.0)};
  const int inputs = shape.inputs();
  for (int o = 0; shape.linear_path >= 0 && o < shape.outputs(); ++o) {
    for (int i = 0; i < inputs; ++i) {
      pass.output[static_cast<std::size_t>(o)] +=
          p[at(shape.linear_path, o, inputs, i)] * u[static_cast<std::size_t>(i)];
    }
  }
  if (gradient == nullptr) return pass;

  for (int o = 0; shape.linear_path >= 0 && o < shape.outputs(); ++o) {
    for (int i = 0; i < inputs; ++i) {
      const auto io = static_cast<std::size_t>(i);
      (*gradient)[at(shape.linear_path, o, inputs, i)] += cotangent[static_cast<std::size_t>(o)] * u[io];
      pass.input_cotangent[io] += cotangent[static_cast<std::size_t>(o)] * p[at(shape.linear_path, o, inputs, i)];
    }
  }
  Doubles dv = cotangent;
  for (std::size_t l = shape.layers.size(); l-- > 0;) {
    const LayerView& layer = shape.layers[l];
    Doubles da(static_cast<std::size_t>(layer.in), 0.0);
    for (int o = 0; o < layer.out; ++o) {
      const double d = dv[static_cast<std::size_t>(o)];
      (*gradient)[static_cast<std::size_t>(layer.bias + o)] += d;
      for (int i = 0; i < layer.in; ++i) {
        (*gradient)[at(layer.weights, o, layer.in, i)] += d * activations[l][static_cast<std::size_t>(i)];
        da[static_cast<std::size_t>(i)] += d * p[at(layer.weights, o, layer.in, i)];
      }
    }
    for (std::size_t i = 0; i < da.size(); ++i) {
      if (l > 0) da[i] *= plain_slope(shape.activation, pre_activations[l - 1][i]);
      if (l == 0) pass.input_cotangent[i] += da[i];
    }
    dv = da;
  }
  return pass;
}

}  // namespace nlo::trainer::testing
