// SPDX-License-Identifier: MIT
// quantise_test.cpp holds it against the runtime's templates.
#include "codegen/reference/quantised_network.h"

#include <nlo/kernels/arithmetic.h>
#include <nlo/kernels/int16.h>

#include <algorithm>

namespace nlo::codegen {
namespace {

using Integers = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;

/// As QuantisedMap::quantised().
std::int32_t quantised(float value, float gain) {
  constexpr float kLimit = static_cast<float>(kernels::int16::kOne);
  float q = rounded(value * gain);
  q = q < kLimit ? q : kLimit;
  q = q > -kLimit ? q : -kLimit;
  return static_cast<std::int32_t>(q < 0 ? q - 0.5F : q + 0.5F);
}

/// As kernels::int16::activated().
std::int32_t activated(bool is_tanh, int shift, std::int32_t sum) {
  if (!is_tanh) return std::min(std::max(sum, 0) >> shift, kernels::int16::kOne);
  constexpr std::int32_t kEnd = 1 << 19;  // 8 in Q16
  return kernels::int16::tanh_q15(std::clamp(sum >> shift, -kEnd, kEnd - 1));
}

}  // namespace

// As kernels::int16::Blocks<rows>::kRows.
Eigen::Index padded_rows(Eigen::Index rows) {
  const auto fours = [](Eigen::Index count) { return (5 - count % 5) % 5; };
  while (4 * fours(rows) > rows) ++rows;
  return rows;
}

Eigen::Index packed_bytes(const QuantisedNetwork& n) {
  const auto numbers = [](Eigen::Index count) { return 4 * count; };  // float and int32
  Eigen::Index bytes = numbers(n.centre.size() + n.gain.size() + n.scale.size() + n.linear_path.size());
  for (const QuantisedLayer& layer : n.layers) {
    const Eigen::Index pairs = (layer.weights.cols() + 1) / 2, rows = padded_rows(layer.weights.rows());
    bytes += numbers(pairs * rows + rows);  // a pair of weights, a bias
  }
  return bytes;
}

Eigen::VectorXf evaluate(const QuantisedNetwork& n, const Eigen::VectorXf& in) {
  Integers a(in.size());
  for (Eigen::Index i = 0; i < in.size(); ++i) a(i) = quantised(in(i)-n.centre(i), n.gain(i));
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const QuantisedLayer& layer = n.layers[l];
    Integers sums = layer.bias + layer.weights.cast<std::int32_t>() * a;
    if (l + 1 < n.layers.size())
      for (std::int32_t& sum : sums) sum = activated(n.activation == Activation::kTanh, layer.shift, sum);
    a = sums;
  }
  Eigen::VectorXf out(n.outputs());
  for (Eigen::Index o = 0; o < out.size(); ++o) {
    out(o) = rounded(n.scale(o) * static_cast<float>(a(o)));
    for (Eigen::Index i = 0; i < n.linear_path.cols(); ++i)
      out(o) = multiply_add<Arithmetic::kDeterministic>(n.linear_path(o, i), in(i), out(o));
  }
  return out;
}

}  // namespace nlo::codegen
