// SPDX-License-Identifier: MIT
#include "trainer/gradients/nn/network_block.h"

#include "codegen/model/activations.h"
#include "nlo/kernels/lane_sum.h"
#include "trainer/gradients/nn/block_activation.h"
#include "trainer/gradients/nn/block_products.h"

namespace nlo::trainer {

namespace {

/// True if s' is not a function of the activations alone, so that the pre-activations must be stored.
template <Activation kKind>
constexpr bool kKeepsInputs = codegen::activation_row(kKind).slope_needs_input;

template <class Scalar>
AlignedVector<Scalar> rows(int count, int stride) {
  return AlignedVector<Scalar>(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride), Scalar(0));
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
  make_room(values_, codegen::activation_row(shape.activation).slope_needs_input);
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
    Math::multiply(parameters + layer.weights, layer.out, layer.in, parameters + layer.bias, in, out);
    if (l == last) break;
    // The activation is a separate pass: inside the tiles of the product GCC serialises the long dependency chain of a
    // tanh.
    Scalar* pre = kKeepsInputs<kKind> ? values_.pre_activations[l].data() : nullptr;
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P v = simd::load<P>(out + i);
      if constexpr (kKeepsInputs<kKind>) simd::store(pre + i, v);
      simd::store(out + i, BlockActivation<kKind>::value(v));
    }
  }
  if (shape_->linear_path >= 0)
    Math::template multiply<true>(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                                  values_.activations[0].data(), values_.activations.back().data());
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
    Math::multiply(parameters + layer.weights, layer.out, layer.in, nullptr, tangents_.activations[l].data(), out);
    if (l == last) break;
    const Scalar* a = values_.activations[l + 1].data();
    const Scalar* v = kKeepsInputs<kKind> ? values_.pre_activations[l].data() : a;
    Scalar* pre = tangents_.pre_activations[l].data();
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P tangent = simd::load<P>(out + i);
      simd::store(pre + i, tangent);
      simd::store(out + i, tangent * BlockActivation<kKind>::slope(simd::load<P>(v + i), simd::load<P>(a + i)));
    }
  }
  if (shape_->linear_path >= 0)
    Math::template multiply<true>(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                                  tangents_.activations[0].data(), tangents_.activations.back().data());
}

/// Computes the gradient and the input cotangent of the linear path. L is small and is read by columns here.
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
        const auto multiply = has_path ? Math::template multiply<true> : Math::template multiply<false>;
        multiply(transposed + layer.weights, layer.in, layer.out, nullptr, cotangent, out);
      };
      to_inputs(dv, values_.input_cotangent.data());
      if constexpr (kTangents) to_inputs(dv_tangent, tangents_.input_cotangent.data());
      return;
    }
    Scalar* out = values_.cotangent[l % 2].data();
    const Scalar* pre = kKeepsInputs<kKind> ? values_.pre_activations[l - 1].data() : in;
    Math::multiply(transposed + layer.weights, layer.in, layer.out, nullptr, dv, out);
    if constexpr (kTangents) {
      Scalar* out_tangent = tangents_.cotangent[l % 2].data();
      const Scalar* pre_tangent = tangents_.pre_activations[l - 1].data();
      Math::multiply(transposed + layer.weights, layer.in, layer.out, nullptr, dv_tangent, out_tangent);
      for (int i = 0; i < layer.in * kStride; i += kWidth) {
        const P v = simd::load<P>(pre + i), a = simd::load<P>(in + i), value = simd::load<P>(out + i);
        const P tangent = simd::load<P>(out_tangent + i), slope = BlockActivation<kKind>::slope(v, a);
        simd::store(out + i,
                    slope * value + BlockActivation<kKind>::curvature(v, a) * simd::load<P>(pre_tangent + i) * tangent);
        simd::store(out_tangent + i, slope * tangent);
      }
    } else {
      for (int i = 0; i < layer.in * kStride; i += kWidth)
        simd::store(out + i, simd::load<P>(out + i) *
                                 BlockActivation<kKind>::slope(simd::load<P>(pre + i), simd::load<P>(in + i)));
    }
  }
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward(const Scalar* parameters) {
  codegen::with_trained_activation(shape_->activation, [&](auto kind) { forward_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward_tangents(const Scalar* parameters) {
  codegen::with_trained_activation(shape_->activation, [&](auto kind) { forward_tangents_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward(const Scalar* parameters, const Scalar* transposed) {
  codegen::with_trained_activation(shape_->activation,
                                   [&](auto kind) { backward_as<kind(), false>(parameters, transposed); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward_tangents(const Scalar* parameters, const Scalar* transposed) {
  codegen::with_trained_activation(shape_->activation,
                                   [&](auto kind) { backward_as<kind(), true>(parameters, transposed); });
}

template class NetworkBlock<float, kBlock>;
template class NetworkBlock<float, 8>;
template class NetworkBlock<double, 8>;

}  // namespace nlo::trainer
