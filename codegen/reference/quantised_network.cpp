// SPDX-License-Identifier: MIT
// The network in integers. quantise_test.cpp compares its results with those of the runtime's templates.
#include "codegen/reference/quantised_network.h"

#include <nlo/kernels/arithmetic.h>
#include <nlo/kernels/int16.h>
#include <nlo/quantised_units.h>

#include <algorithm>

namespace nlo::codegen {
namespace {

using Integers = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;

/// Returns the argument of tanh in Q16, limited to |argument| <= 8.
std::int32_t argument(int shift, std::int32_t sum) {
  constexpr std::int32_t kEnd = 1 << 19;  // 8 in Q16
  return std::clamp(sum >> shift, -kEnd, kEnd - 1);
}

/// Computes kernels::int16::activated().
std::int32_t activated(Activation kind, int shift, std::int32_t sum) {
  if (kind == Activation::kRelu) return std::min(std::max(sum, 0) >> shift, kernels::int16::kOne);
  if (kind == Activation::kSilu) return kernels::int16::silu_q11(argument(shift, sum));
  return kernels::int16::tanh_q15(argument(shift, sum));
}

Integers sums(const QuantisedLayer& layer, const Integers& in) {
  return layer.bias + layer.weights.cast<std::int32_t>() * in;
}

/// Computes FallbackRows::correct(); in: [in; products].
void apply(const Fallback& fallback, const Eigen::VectorXf& in, Eigen::VectorXf& out) {
  for (std::size_t f = 0; f < fallback.outputs.size(); ++f) {
    const auto at = static_cast<Eigen::Index>(f);
    auto row = static_cast<float>(fallback.offset(at));
    for (Eigen::Index i = 0; i < in.size(); ++i)
      row = multiply_add<Arithmetic::kDeterministic>(static_cast<float>(fallback.rows(at, i)), in(i), row);
    float& estimate = out(fallback.outputs[f]);
    estimate = fall_back<Arithmetic::kDeterministic>(estimate, row, static_cast<float>(1.0 / fallback.reach(at)));
  }
}

}  // namespace

// Equals kernels::int16::Blocks<rows>::kRows.
Eigen::Index padded_rows(Eigen::Index rows) {
  const auto fours = [](Eigen::Index count) { return (5 - count % 5) % 5; };
  while (4 * fours(rows) > rows) ++rows;
  return rows;
}

Eigen::Index packed_bytes(const QuantisedNetwork& n) {
  const auto numbers = [](Eigen::Index count) { return 4 * count; };  // bytes of floats or int32
  const Eigen::Index fallbacks = n.fallback.rows.rows();
  Eigen::Index bytes = numbers(n.centre.size() + n.gain.size() + n.scale.size() + n.linear_path.size() +
                               static_cast<Eigen::Index>(n.products.size()) +  // two indices of 16 bits
                               n.fallback.rows.size() + 2 * fallbacks + (fallbacks + 1) / 2);
  for (const QuantisedLayer& layer : n.layers) {
    const Eigen::Index pairs = (layer.weights.cols() + 1) / 2, rows = padded_rows(layer.weights.rows());
    bytes += numbers(pairs * rows + rows);  // 32 bits for a pair of weights or a bias
  }
  return bytes;
}

Eigen::VectorXf evaluate(const QuantisedNetwork& n, const Eigen::VectorXf& inputs) {
  const Eigen::VectorXf in = with_products(n.products, inputs);
  Integers a(in.size());
  for (Eigen::Index i = 0; i < in.size(); ++i) a(i) = kernels::int16::quantised(in(i)-n.centre(i), n.gain(i));
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const QuantisedLayer& layer = n.layers[l];
    a = sums(layer, a);
    if (l + 1 < n.layers.size())
      for (std::int32_t& sum : a) sum = activated(n.activation, layer.shift, sum);
  }
  Eigen::VectorXf out(n.outputs());
  for (Eigen::Index o = 0; o < out.size(); ++o) {
    out(o) = rounded(n.scale(o) * static_cast<float>(a(o)));
    for (Eigen::Index i = 0; i < n.linear_path.cols(); ++i)
      out(o) = multiply_add<Arithmetic::kDeterministic>(n.linear_path(o, i), in(i), out(o));
  }
  apply(n.fallback, in, out);
  return out;
}

Eigen::VectorXf stepped(const QuantisedUnits& units, const Eigen::VectorXf& z, const Eigen::VectorXf& y, bool regular,
                        float periods) {
  namespace q = kernels::int16;
  const QuantisedNetwork& gates = units.gates;
  const QuantisedLayer &gate = gates.layers.front(), &candidate = units.candidate.layers.front();
  const Eigen::Index nz = z.size();
  Integers latent(nz), in(nz + y.size());
  for (Eigen::Index r = 0; r < nz; ++r) {
    latent(r) = q::integer_latent(z(r));
    in(r) = latent(r) >> q::kBelowQ15;
  }
  for (Eigen::Index j = 0; j < y.size(); ++j) in(nz + j) = q::quantised(y(j) - gates.centre(j), gates.gain(j));
  const Integers a = sums(gate, in);
  for (Eigen::Index r = 0; r < nz; ++r)
    in(r) = (in(r) * (q::kOne + 1 + activated(Activation::kTanh, gate.shift, a(nz + r)))) >> 16;
  const Integers c = sums(candidate, in);
  Eigen::VectorXf next(nz);
  for (Eigen::Index r = 0; r < nz; ++r) {
    const std::int32_t share = regular ? (q::kOne + 1 + activated(Activation::kTanh, gate.shift, a(r))) >> 1
                                       : q::share_over(argument(gate.shift, a(r)), periods);
    next(r) = q::float_latent(q::moved(latent(r), share, activated(Activation::kTanh, candidate.shift, c(r))));
  }
  return next;
}

}  // namespace nlo::codegen
