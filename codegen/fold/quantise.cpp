// SPDX-License-Identifier: MIT
#include "codegen/fold/quantise.h"

#include <fmt/format.h>
#include <nlo/kernels/int16.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "codegen/model/activations.h"
#include "codegen/model/field_checks.h"
#include "codegen/reference/reference_network.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

constexpr double kOne = kernels::int16::kOne;
constexpr double kLargestSum = std::numeric_limits<std::int32_t>::max();
constexpr int kLargestShift = 31;
constexpr double kTanhEnd = 8.0;             // the table of tanh ends here with +-1
constexpr double kSiluEnd = 2.0 * kTanhEnd;  // range of silu in int16

/// A layer in real numbers over the integers q that it reads: v = weights q + bias.
using RealLayer = DenseLayer;

double absolute_sum(const RealLayer& layer, Eigen::Index row) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < layer.weights.cols(); ++i) sum += std::abs(layer.weights(row, i));
  return sum;
}

/// Multiplies row `o` of `layer` by `scale`, adds `half` to its bias, and rounds. Returns false if a weight or a sum
/// does not fit.
bool round_row(const RealLayer& layer, Eigen::Index o, double scale, double half, QuantisedLayer& to) {
  double worst = std::abs(std::round(layer.bias(o) * scale) + half);
  for (Eigen::Index i = 0; i < layer.weights.cols(); ++i) {
    const double weight = std::round(layer.weights(o, i) * scale);
    if (!(std::abs(weight) <= kOne)) return false;
    worst += std::abs(weight) * kOne;
    to.weights(o, i) = static_cast<std::int16_t>(weight);
  }
  if (!(worst <= kLargestSum)) return false;  // exact: all terms are integers below 2^53
  to.bias(o) = static_cast<std::int32_t>(std::round(layer.bias(o) * scale) + half);
  return true;
}

QuantisedLayer sized_like(const RealLayer& layer) {
  QuantisedLayer sized;
  sized.weights.resize(layer.weights.rows(), layer.weights.cols());
  sized.bias.resize(layer.bias.size());
  return sized;
}

/// Returns a layer whose sums are `unit` 2^shift per unit of v, with the largest shift that all rows allow. Shifting
/// rounds down; half a unit of the result in the bias turns this into rounding to nearest.
QuantisedLayer hidden_layer(const RealLayer& layer, double unit, const std::string& name) {
  QuantisedLayer quantised = sized_like(layer);
  for (quantised.shift = kLargestShift; quantised.shift >= 1; --quantised.shift) {
    Eigen::Index o = 0;
    while (o < layer.bias.size() &&
           round_row(layer, o, std::ldexp(unit, quantised.shift), std::ldexp(0.5, quantised.shift), quantised))
      ++o;
    if (o == layer.bias.size()) return quantised;
  }
  Eigen::Index worst = 0;
  const auto reach = [&](Eigen::Index o) { return std::abs(layer.bias(o)) + absolute_sum(layer, o) * kOne; };
  for (Eigen::Index o = 1; o < layer.bias.size(); ++o)
    if (reach(o) > reach(worst)) worst = o;
  fail(
      "{}: neuron {} has sums up to {:.3g}, but int16 allows at most {:.3g}; export with --scalar float, or "
      "train "
      "with weight_decay",
      name, worst, reach(worst), kLargestSum / (2.0 * unit));
}

/// Returns the last layer, each row with the largest scale that it allows.
QuantisedLayer last_layer(const RealLayer& layer, std::size_t index, Eigen::VectorXf& scale) {
  QuantisedLayer quantised = sized_like(layer);
  scale.resize(layer.bias.size());
  const double rounding = (kOne * static_cast<double>(layer.weights.cols()) + 1.0) / 2.0;  // largest total of all terms
  for (Eigen::Index o = 0; o < layer.bias.size(); ++o) {
    constexpr double kLargestScale = 0x1p60;  // for rows whose weights are almost all zero
    double sums_per_unit = kLargestScale;
    if (const double reach = std::abs(layer.bias(o)) + absolute_sum(layer, o) * kOne; reach > 0.0)
      sums_per_unit = std::min(sums_per_unit, (kLargestSum - rounding) / reach);
    if (const double most = layer.weights.row(o).cwiseAbs().maxCoeff(); most > 0.0)
      sums_per_unit = std::min(sums_per_unit, kOne / most);
    scale(o) = static_cast<float>(1.0 / sums_per_unit);
    if (!(sums_per_unit > 0.0) || !std::isfinite(scale(o)) || !round_row(layer, o, sums_per_unit, 0.0, quantised))
      fail(
          "inverse_map.layers[{}]: row {} exceeds the range of int16; export with --scalar float, or train with "
          "weight_decay",
          index, o);
  }
  return quantised;
}

/// Returns the layer over integers. `per_unit`: the value of one unit; `offset`: the value at integer 0.
RealLayer over_integers(RealLayer layer, const Eigen::VectorXd& per_unit, const Eigen::VectorXd& offset) {
  layer.bias += layer.weights * offset;
  layer.weights = layer.weights * per_unit.asDiagonal();
  return layer;
}

/// Returns a layer whose sums are arguments of tanh. A neuron that is always saturated gets a smaller bias, with which
/// it stays saturated; this permits a larger scale.
QuantisedLayer tanh_layer(RealLayer layer, const std::string& name) {
  for (Eigen::Index o = 0; o < layer.bias.size(); ++o) {
    const double enough = kTanhEnd + absolute_sum(layer, o) * kOne;
    layer.bias(o) = std::clamp(layer.bias(o), -enough, enough);
  }
  return hidden_layer(layer, 0x1p16, name);
}

/// Sets the centre and the gain that map [low, high] to Q15. An interval narrower than the spacing of floats is
/// widened to it, because its gain would be infinite. Throws Error for a range beyond float.
void scale_input(double low, double high, const std::string& name, float& centre, float& gain) {
  const double middle = low + (high - low) / 2.0;
  const double half = std::max({(high - low) / 2.0, std::abs(middle) * 0x1p-23, 0x1p-60});
  centre = static_cast<float>(middle);
  gain = static_cast<float>(kOne / half);
  if (!std::isfinite(centre) || !(gain > 0.0F))
    fail("the range [{}, {}] of {} is beyond float; export with --scalar double", low, high, name);
}

void check_supported(const Model& m) {
  if (module_of(m).abilities().int16) return;
  fail("int16 exists only for structure {}, but this model is {}; export with --scalar float",
       names_of_structures([](const StructureModule& s) { return s.abilities().int16; }), structure_name(m));
}

}  // namespace

InputBox input_box(const Model& m, const FoldedModel& folded) {
  const Eigen::VectorXd &low = folded.ranges.kept_min, &high = folded.ranges.kept_max;
  InputBox box{m.latent_min, m.latent_max};
  for (int j = 0; j < m.ny(); ++j) {
    if (!is_relative(m, j)) continue;
    for (int r = 0; r < m.nz(); ++r) {
      const double a = folded.steady_gain(r, j) * low(j), b = folded.steady_gain(r, j) * high(j);
      box.min(r) += std::min(a, b);
      box.max(r) += std::max(a, b);
    }
  }
  if (folded.inverse_map()->inputs() > m.nz()) {
    box.min.conservativeResize(m.nz() + m.nr());
    box.max.conservativeResize(m.nz() + m.nr());
    box.min.tail(m.nr()) = low;
    box.max.tail(m.nr()) = high;
  }
  return box;
}

namespace {

/// Returns the box of [in; products].
InputBox box_with_products(const FoldedNetwork& n, InputBox box) {
  box.min.conservativeResize(n.columns());
  box.max.conservativeResize(n.columns());
  for (std::size_t p = 0; p < n.products.size(); ++p) {
    const auto [factor, clock] = n.products[p];
    const auto [low, high] = std::minmax({box.min(factor) * box.min(clock), box.min(factor) * box.max(clock),
                                          box.max(factor) * box.min(clock), box.max(factor) * box.max(clock)});
    box.min(n.inputs() + static_cast<Eigen::Index>(p)) = low;
    box.max(n.inputs() + static_cast<Eigen::Index>(p)) = high;
  }
  return box;
}

}  // namespace

QuantisedNetwork quantise(const FoldedNetwork& n, const InputBox& inputs, const std::vector<double>& largest) {
  const InputBox box = box_with_products(n, inputs);
  if (!activation_row(n.activation).has_int16() && n.layers.size() > 1)
    fail(
        "int16 supports tanh and relu, but this model's activation is {}; export with --scalar float, or train with "
        "tanh",
        activation_row(n.activation).name);
  QuantisedNetwork q{n.layers.size() > 1 ? n.activation : Activation::kTanh,
                     {},
                     {},
                     {},
                     {},
                     n.linear_path.cast<float>(),
                     n.products,
                     n.fallback};
  q.centre.resize(n.columns());
  q.gain.resize(n.columns());

  // The value of one unit of an integer, and the value that remains when all integers are zero.
  Eigen::VectorXd per_unit(n.columns()), offset(n.columns());
  for (Eigen::Index i = 0; i < n.columns(); ++i) {
    scale_input(box.min(i), box.max(i), fmt::format("input {} of inverse_map", i), q.centre(i), q.gain(i));
    per_unit(i) = 1.0 / static_cast<double>(q.gain(i));
    offset(i) = static_cast<double>(q.centre(i));
  }

  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const RealLayer real = over_integers(n.layers[l], per_unit, offset);
    const std::string name = fmt::format("inverse_map.layers[{}]", l);
    if (l + 1 == n.layers.size()) {
      q.layers.push_back(last_layer(real, l, q.scale));
      break;
    }
    if (n.activation == Activation::kRelu) {
      q.layers.push_back(hidden_layer(real, kOne / largest[l], name));
      per_unit.setConstant(real.bias.size(), largest[l] / kOne);
      offset.setZero(real.bias.size());
      continue;
    }
    // The table of tanh rounds down.
    const bool silu = n.activation == Activation::kSilu;
    if (silu && largest[l] > kSiluEnd)
      fail(
          "{} reaches {:.3g}, but int16 supports silu only up to {}; export with --scalar float, or train with "
          "weight_decay",
          name, largest[l], kSiluEnd);
    q.layers.push_back(tanh_layer(silu ? RealLayer{real.weights / 2.0, real.bias / 2.0} : real, name));
    per_unit.setConstant(real.bias.size(), silu ? kSiluEnd / (kOne + 1.0) : 1.0 / kOne);
    offset = per_unit / 2.0;
  }
  return q;
}

std::vector<double> largest_activations(const Network& map, const FoldedNetwork& n, const InputBox& box) {
  constexpr double kHeadroom = 1.1;  // for noise, and for plants that differ from the model
  constexpr Eigen::Index kInputs = 4096;
  if (std::isfinite(activation_row(n.activation).largest_value))
    return std::vector<double>(n.layers.size() - 1, activation_row(n.activation).largest_value);
  std::vector<double> largest = map.largest_activations;
  if (largest.empty()) {
    std::uint64_t state = 1;
    Eigen::MatrixXd in(n.inputs(), kInputs);
    for (Eigen::Index k = 0; k < kInputs; ++k)
      for (Eigen::Index i = 0; i < in.rows(); ++i) {
        state = state * 6364136223846793005U + 1442695040888963407U;  // Knuth's, as in MMIX
        const double uniform = static_cast<double>(state >> 11) * 0x1p-53;
        in(i, k) = box.min(i) + (box.max(i) - box.min(i)) * (k % 2 == 0 ? uniform : std::round(uniform));
      }
    largest = ReferenceNetwork<double>(unfolded(n, n.inputs())).largest_activations(in);
  }
  for (double& value : largest) value = std::max(kHeadroom * value, 0x1p-60);  // all outputs of a layer may be 0
  return largest;
}

namespace {

/// The units read z rounded down, and the reset gates round it down again, so each value is half a unit too low on
/// average. The biases make up for it.
QuantisedUnits quantised_units(const Model& m, const FoldedModel& folded) {
  const int nz = m.nz(), nr = m.nr();
  QuantisedNetwork gates{Activation::kTanh, Eigen::VectorXf(nr), Eigen::VectorXf(nr), {}, {}, {}};
  QuantisedNetwork candidate{Activation::kTanh, {}, {}, {}, {}, {}};
  Eigen::VectorXd per_unit = Eigen::VectorXd::Constant(nz + nr, 1.0 / (kOne + 1.0)), offset = per_unit / 2.0;
  const Eigen::VectorXd low = reading_min(m), high = reading_max(m);
  for (int j = 0; j < nr; ++j) {
    scale_input(low(j), high(j), fmt::format("reading {}", j), gates.centre(j), gates.gain(j));
    per_unit(nz + j) = 1.0 / static_cast<double>(gates.gain(j));
    offset(nz + j) = static_cast<double>(gates.centre(j));
  }
  for (const auto& [field, network] : {std::pair{"gates", &gates}, std::pair{"candidate", &candidate}})
    network->layers.push_back(tanh_layer(over_integers(folded.network(field).layers.front(), per_unit, offset),
                                         fmt::format("{}.layers[0]", field)));
  return {std::move(gates), std::move(candidate)};
}

}  // namespace

QuantisedModel quantise(const Model& m, const FoldedModel& folded) {
  check_supported(m);
  const InputBox box = input_box(m, folded);
  const FoldedNetwork& map = *folded.inverse_map();
  QuantisedModel q{quantise(map, box, largest_activations(*inverse_map(m), map, box))};
  if (module_of(m).gated_units(m) == m.nz()) q.units = quantised_units(m, folded);
  return q;
}

}  // namespace nlo::codegen
