// SPDX-License-Identifier: MIT
#include "trainer/nn/network_block.h"

#include <cmath>
#include <type_traits>

#include "trainer/nn/block_products.h"

namespace nlo::trainer {

namespace {

/// tanh as it flies in float; in double, where gradients are compared with finite differences, the exact one: the
/// slope 1 - a^2 is that of tanh, not of its approximation.
template <class P>
NLO_INLINE P smooth_tanh(P v) {
  using Scalar = typename simd::ScalarOf<P>::Type;
  if constexpr (std::is_same_v<P, double>) {
    return std::tanh(v);
  } else if constexpr (std::is_same_v<Scalar, double>) {
    constexpr int kN = sizeof(P) / sizeof(double);
    for (int i = 0; i < kN; ++i) v[i] = std::tanh(v[i]);
    return v;
  } else {
    return tanh_rational(v);
  }
}

template <Activation kKind, class P>
NLO_INLINE P value_of(P v) {
  if constexpr (kKind == Activation::kTanh) {
    return smooth_tanh(v);
  } else if constexpr (kKind == Activation::kSilu) {
    const P half = v * simd::literal<P>(0.5);
    return half + half * smooth_tanh(half);
  } else {
    return activate<kKind>(v);
  }
}

/// s'(v), from v and a = s(v).
template <Activation kKind, class P>
NLO_INLINE P slope_of(P v, P a) {
  if constexpr (kKind == Activation::kSilu) {
    const P half = P{} + simd::literal<P>(0.5);
    const P s = half + half * smooth_tanh(v * half);
    return s + a * (P{} + simd::literal<P>(1.0) - s);
  } else {
    return activation_slope<kKind>(v, a);
  }
}

/// s''(v), from v and a = s(v).
template <Activation kKind, class P>
NLO_INLINE P curvature_of(P v, P a) {
  const P one = P{} + simd::literal<P>(1.0);
  const auto two = simd::literal<P>(2.0);
  if constexpr (kKind == Activation::kTanh) {
    return -two * a * (one - a * a);
  } else if constexpr (kKind == Activation::kRelu) {
    return P{};
  } else {  // s (1 - s) (2 + v (1 - 2 s)), s = sigmoid(v)
    const P half = P{} + simd::literal<P>(0.5);
    const P s = half + half * smooth_tanh(v * half);
    return s * (one - s) * (P{} + two + v * (one - two * s));
  }
}

template <class Scalar>
std::vector<Scalar> rows(int count, int stride) {
  return std::vector<Scalar>(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride), Scalar(0));
}

/// Calls run(std::integral_constant<Activation, kind>) for the kind at hand.
template <class Run>
void with_activation(Activation kind, const Run& run) {
  switch (kind) {
    case Activation::kTanh:
      return run(std::integral_constant<Activation, Activation::kTanh>{});
    case Activation::kRelu:
      return run(std::integral_constant<Activation, Activation::kRelu>{});
    case Activation::kSilu:
      return run(std::integral_constant<Activation, Activation::kSilu>{});
    case Activation::kTanh5e6:
    case Activation::kTanh5e5:
      break;  // what an export may choose; training has the best one
  }
}

}  // namespace

template <class Scalar, int kColumns>
NetworkBlock<Scalar, kColumns>::NetworkBlock(const NetworkShape& shape, bool with_tangents) : shape_(&shape) {
  int widest = shape.inputs();
  for (const LayerView& layer : shape.layers) widest = std::max(widest, layer.out);
  const auto make_room = [&](Pass& pass, bool keeps_pre_activations) {
    pass.activations.push_back(rows<Scalar>(shape.inputs(), kStride));
    for (const LayerView& layer : shape.layers) {
      pass.activations.push_back(rows<Scalar>(layer.out, kStride));
      if (keeps_pre_activations) pass.pre_activations.push_back(rows<Scalar>(layer.out, kStride));
    }
    for (auto& cotangent : pass.cotangent) cotangent = rows<Scalar>(widest, kStride);
    pass.input_cotangent = rows<Scalar>(shape.inputs(), kStride);
  };
  make_room(values_, shape.activation == Activation::kSilu);
  if (with_tangents) make_room(tangents_, true);
  gradient_ = rows<Scalar>(shape.parameters, Products<Scalar, kColumns>::kLanesPerWeight);
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::clear_gradient() {
  std::fill(gradient_.begin(), gradient_.end(), Scalar(0));
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::gradient(Scalar* out) const {
  constexpr int kLanes = Products<Scalar, kColumns>::kLanesPerWeight;
  using P = simd::Pack<Scalar, kLanes>;
  for (int i = 0; i < shape_->parameters; ++i) {
    out[i] = simd::sum<Scalar>(simd::load<P>(gradient_.data() + static_cast<std::ptrdiff_t>(i) * kLanes));
  }
}

template <class Scalar, int kColumns>
template <Activation kKind>
void NetworkBlock<Scalar, kColumns>::forward_as(const Scalar* parameters) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const std::size_t last = shape_->layers.size() - 1;
  for (std::size_t l = 0; l <= last; ++l) {
    const LayerView& layer = shape_->layers[l];
    Scalar* out = values_.activations[l + 1].data();
    const Scalar* in = values_.activations[l].data();
    Math::product(parameters + layer.weights, layer.out, layer.in, parameters + layer.bias, in,
                  [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out + row * kStride + s, v); });
    if (l == last) break;
    // A pass of its own: inside the product's tiles GCC serialises the long dependency chain of a tanh.
    Scalar* pre = kKind == Activation::kSilu ? values_.pre_activations[l].data() : nullptr;
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P v = simd::load<P>(out + i);
      if constexpr (kKind == Activation::kSilu) simd::store(pre + i, v);
      simd::store(out + i, value_of<kKind>(v));
    }
  }
  if (shape_->linear_path >= 0) {
    Scalar* out = values_.activations.back().data();
    Math::product(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                  values_.activations[0].data(), [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                    simd::store(out + row * kStride + s, simd::load<P>(out + row * kStride + s) + v);
                  });
  }
}

template <class Scalar, int kColumns>
template <Activation kKind>
void NetworkBlock<Scalar, kColumns>::forward_tangents_as(const Scalar* parameters) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const std::size_t last = shape_->layers.size() - 1;
  for (std::size_t l = 0; l <= last; ++l) {
    const LayerView& layer = shape_->layers[l];
    Scalar* out = tangents_.activations[l + 1].data();
    Math::product(parameters + layer.weights, layer.out, layer.in, nullptr, tangents_.activations[l].data(),
                  [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out + row * kStride + s, v); });
    if (l == last) break;
    const Scalar* a = values_.activations[l + 1].data();
    const Scalar* v = kKind == Activation::kSilu ? values_.pre_activations[l].data() : a;
    Scalar* pre = tangents_.pre_activations[l].data();
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P tangent = simd::load<P>(out + i);
      simd::store(pre + i, tangent);
      // relu: a > 0 exactly where v > 0
      simd::store(out + i, tangent * slope_of<kKind>(simd::load<P>(v + i), simd::load<P>(a + i)));
    }
  }
  if (shape_->linear_path >= 0) {
    Scalar* out = tangents_.activations.back().data();
    Math::product(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                  tangents_.activations[0].data(), [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                    simd::store(out + row * kStride + s, simd::load<P>(out + row * kStride + s) + v);
                  });
  }
}

/// Gradient and input cotangent through the linear path; L is small, and read by columns here.
template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::path_backward(const Scalar* parameters, Pass& pass) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const Scalar* cotangent = pass.last_cotangent();
  const int inputs = shape_->inputs();
  Math::outer_product(cotangent, shape_->outputs(), pass.activations[0].data(), inputs,
                      gradient_.data() + static_cast<std::ptrdiff_t>(shape_->linear_path) * Math::kLanesPerWeight);
  const Scalar* path = parameters + shape_->linear_path;
  for (int i = 0; i < inputs; ++i) {
    for (int s = 0; s < kColumns; s += kWidth) {
      P sum{};
      for (int o = 0; o < shape_->outputs(); ++o) {
        sum += simd::broadcast<P>(path[o * inputs + i]) * simd::load<P>(cotangent + o * kStride + s);
      }
      simd::store(pass.input_cotangent.data() + i * kStride + s, sum);
    }
  }
}

template <class Scalar, int kColumns>
template <Activation kKind, bool kTangents>
void NetworkBlock<Scalar, kColumns>::backward_as(const Scalar* parameters, const Scalar* transposed) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const bool has_path = shape_->linear_path >= 0;
  if (has_path) {
    path_backward(parameters, values_);
    if constexpr (kTangents) path_backward(parameters, tangents_);
  }
  for (std::size_t l = shape_->layers.size(); l-- > 0;) {
    const LayerView& layer = shape_->layers[l];
    const Scalar* dv = values_.cotangent[(l + 1) % 2].data();
    const Scalar* in = values_.activations[l].data();
    Scalar* weights = gradient_.data() + static_cast<std::ptrdiff_t>(layer.weights) * Math::kLanesPerWeight;
    Math::outer_product(dv, layer.out, in, layer.in, weights);
    Math::row_sums(dv, layer.out, gradient_.data() + static_cast<std::ptrdiff_t>(layer.bias) * Math::kLanesPerWeight);
    const Scalar* dv_tangent = nullptr;
    if constexpr (kTangents) {
      dv_tangent = tangents_.cotangent[(l + 1) % 2].data();
      Math::outer_product(dv_tangent, layer.out, tangents_.activations[l].data(), layer.in, weights);
    }
    if (l == 0) {
      const auto to_inputs = [&](const Scalar* cotangent, Scalar* out) {
        Math::product(transposed + layer.weights, layer.in, layer.out, nullptr, cotangent,
                      [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                        simd::store(out + row * kStride + s, has_path ? simd::load<P>(out + row * kStride + s) + v : v);
                      });
      };
      to_inputs(dv, values_.input_cotangent.data());
      if constexpr (kTangents) to_inputs(dv_tangent, tangents_.input_cotangent.data());
      return;
    }
    Scalar* out = values_.cotangent[l % 2].data();
    const Scalar* pre = kKind == Activation::kSilu ? values_.pre_activations[l - 1].data() : in;
    if constexpr (kTangents) {
      Scalar* out_tangent = tangents_.cotangent[l % 2].data();
      const Scalar* pre_tangent = tangents_.pre_activations[l - 1].data();
      Math::product(transposed + layer.weights, layer.in, layer.out, nullptr, dv_tangent,
                    [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out_tangent + row * kStride + s, v); });
      Math::product(
          transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P value) NLO_INLINE_LAMBDA {
            const int at = row * kStride + s;
            const P v = simd::load<P>(pre + at), a = simd::load<P>(in + at);
            const P tangent = simd::load<P>(out_tangent + at), slope = slope_of<kKind>(v, a);
            simd::store(out + at,
                        slope * value + curvature_of<kKind>(v, a) * simd::load<P>(pre_tangent + at) * tangent);
            simd::store(out_tangent + at, slope * tangent);
          });
    } else {
      Math::product(
          transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P v) NLO_INLINE_LAMBDA {
            const P slope =
                slope_of<kKind>(simd::load<P>(pre + row * kStride + s), simd::load<P>(in + row * kStride + s));
            simd::store(out + row * kStride + s, v * slope);
          });
    }
  }
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward(const Scalar* parameters) {
  with_activation(shape_->activation, [&](auto kind) { forward_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward_tangents(const Scalar* parameters) {
  with_activation(shape_->activation, [&](auto kind) { forward_tangents_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward(const Scalar* parameters, const Scalar* transposed) {
  with_activation(shape_->activation, [&](auto kind) { backward_as<kind(), false>(parameters, transposed); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward_tangents(const Scalar* parameters, const Scalar* transposed) {
  with_activation(shape_->activation, [&](auto kind) { backward_as<kind(), true>(parameters, transposed); });
}

template class NetworkBlock<float, kBlock>;
template class NetworkBlock<float, 8>;
template class NetworkBlock<double, 8>;

}  // namespace nlo::trainer
