// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlo/kernels/panels.h>

#include <vector>

#include "codegen/model/activations.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

// Packing a layer at compile time takes g++ some 25 us per weight, and clang++ refuses large layers. Smaller networks
// keep the readable form.
constexpr Eigen::Index kLargeNetwork = 16384, kLargeLayer = 1024;  // weights

/// Writes the initialiser of PanelDense::weights in the order of the memory: one input of one tile of outputs per line.
std::string panels(const Initialiser& init, const Eigen::MatrixXd& weights, const std::string& field) {
  const kernels::PanelLayout layout{static_cast<int>(weights.cols()), static_cast<int>(weights.rows())};
  Eigen::VectorXd packed = Eigen::VectorXd::Zero(layout.weights());
  std::vector<bool> starts_line(static_cast<std::size_t>(layout.weights()), false);
  for (int o = 0; o < layout.out; ++o) {
    const bool row_major = layout.rest_is_row_major() && o >= layout.wide() + layout.eight();
    for (int i = 0; i < layout.in; ++i) {
      const int at = layout.weight_position(o, i);
      packed(at) = weights(o, i);
      starts_line[static_cast<std::size_t>(at)] =
          row_major ? i == 0 : o == 0 || layout.weight_position(o - 1, i) != at - 1;
    }
  }
  std::string text = "{";
  for (int at = 0; at < layout.weights(); ++at)
    text += (starts_line[static_cast<std::size_t>(at)] ? "\n      " : " ") + init(packed(at), field) + ",";
  return text + "\n    }";
}

/// Writes small integers of any type, `{a, b, c}`.
template <class Vector>
std::string integers(const Vector& values) {
  std::string text = "{";
  for (Eigen::Index i = 0; i < values.size(); ++i)
    text += fmt::format("{}{}", i > 0 ? ", " : "", static_cast<int>(values(i)));
  return text + "}";
}

std::string integer_layer(const QuantisedLayer& layer, const std::string& name, const std::string& reads) {
  std::string rows;
  for (Eigen::Index o = 0; o < layer.bias.size(); ++o) rows += "      " + integers(layer.weights.row(o)) + ",\n";
  return fmt::format(
      "\n// {0} x {1}: one neuron per line, reads {2}.\n"
      "inline constexpr QuantisedDense<{1}, {0}, {3}> {4} = {{\n"
      "    .weights = {{\n{5}    }},\n"
      "    .bias = {6},\n"
      "}};\n",
      layer.weights.rows(), layer.weights.cols(), reads, layer.shift, name, rows, integers(layer.bias));
}

}  // namespace

std::string CppNetwork::made() const {
  std::string text = quantised ? "make_quantised_mlp" : "make_mlp";
  text += "<" + std::string(activation_row(network.activation).identifier) + ">(";
  for (std::size_t l = 1; l <= network.layers.size(); ++l)
    text += fmt::format("{}weights::k{}{}", l > 1 ? ", " : "", layer, l);
  return text + ")";
}

std::string CppNetwork::layers(const Initialiser& init) const {
  std::string text;
  Eigen::Index weights = 0;
  for (const DenseLayer& dense : network.layers) weights += dense.weights.size();
  const bool is_large = weights > kLargeNetwork;
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    const DenseLayer& dense = network.layers[l];
    const std::string layer_reads = l == 0 ? reads : fmt::format("layer {}", l);
    if (quantised) {
      text += integer_layer(quantised->layers[l], fmt::format("k{}{}", layer, l + 1), layer_reads);
      continue;
    }
    const std::string weights_field = fmt::format("{}.layers[{}].weights", field, l);
    const bool laid_out = is_large && dense.weights.size() > kLargeLayer;
    text += fmt::format(
        "\n// {0} x {1}: {8}, reads {2}.\n"
        "inline constexpr {9}<{3}, {1}, {0}> k{4}{5} = {{\n"
        "    .weights = {6},\n"
        "    .bias = {7},\n"
        "}};\n",
        dense.weights.rows(), dense.weights.cols(), layer_reads, init.weight_type(), layer, l + 1,
        laid_out ? panels(init, dense.weights, weights_field) : init.rows(dense.weights, 6, weights_field),
        init.vector(dense.bias, fmt::format("{}.layers[{}].bias", field, l)),
        laid_out ? "one input of a tile of neurons per line, as panels.h lays them out" : "one neuron per line",
        laid_out ? "PanelDense" : "Dense");
  }
  if (error)
    text += fmt::format(
        "\n// {0} x {1}: one state per line, log2 sigma of its error; reads the last hidden layer and its squares.\n"
        "inline constexpr Dense<{2}, {1}, {0}> kErrorHead = {{\n"
        "    .weights = {3},\n"
        "    .bias = {4},\n"
        "}};\n",
        error->layer.weights.rows(), error->layer.weights.cols(), init.scalar_name(),
        init.rows(error->layer.weights, 6, "error.weights"), init.vector(error->layer.bias, "error.bias"));
  return text;
}

std::string CppNetwork::using_declaration() const {
  return fmt::format("using {} = decltype({});\n", type, made());
}

std::string CppNetwork::map_type(const Initialiser& init) const {
  if (quantised && quantised->scale.size() == 0)
    return "QuantisedUnits<" + type +
           (quantised->centre.size() > 0 ? ", " + std::to_string(quantised->centre.size()) : "") + ">";
  const Eigen::Index out = network.layers.back().bias.size();
  const bool has_more = has_products() || has_fallback();
  const std::string path = has_linear_path()
                               ? fmt::format(", LinearPath<{}, {}, {}>", init.scalar_name(), network.columns(), out)
                           : error || has_more ? ", NoLinearPath"
                                               : "";
  const std::string head =
      error ? fmt::format(", ErrorHead<{}, {}, {}>", init.scalar_name(), error->layer.weights.cols() / 2, out)
      : has_more && !quantised ? ", NoErrorHead"
                               : "";
  const std::string products = has_products()   ? fmt::format(", ClockProducts<{}>", network.products.size())
                               : has_fallback() ? ", NoClockProducts"
                                                : "";
  const std::string fallback = has_fallback() ? fmt::format(", FallbackRows<{}, {}, {}>", init.scalar_name(),
                                                            network.columns(), network.fallback.outputs.size())
                                              : "";
  return std::string(quantised ? "QuantisedMap" : "LearnedMap") + "<" + type + path + head + products + fallback + ">";
}

std::string CppNetwork::initialiser(const Initialiser& init, const std::string& member) const {
  std::string text = fmt::format("    .{} = {{\n", member);
  if (quantised && quantised->centre.size() > 0)
    text += fmt::format("        .centre = {},\n        .gain = {},  // to +-32767\n",
                        init.vector(quantised->centre.cast<double>(), "latent_min"),
                        init.vector(quantised->gain.cast<double>(), "latent_max"));
  text += fmt::format("        .mlp = {},\n", made());
  if (quantised && quantised->scale.size() > 0)
    text += fmt::format("        .scale = {},\n", init.vector(quantised->scale.cast<double>(), field + ".layers"));
  if (has_linear_path())
    text +=
        fmt::format("        .linear_path = {{.weights = {}}},\n", init.rows(network.linear_path, 12, field + ".skip"));
  if (error)
    text += fmt::format(
        "        .error = {{.layer = pack(weights::kErrorHead),\n"
        "                  .lowest = {},\n"
        "                  .highest = {},\n"
        "                  .bound_95 = {}}},\n",
        init.vector(error->lowest, "error.log_min"), init.vector(error->highest, "error.log_max"),
        init.vector(error->bound_95, "error.factor_95"));
  if (has_products()) {
    std::string pairs;
    for (const auto& [factor, clock] : network.products)
      pairs += fmt::format("{}{{{}, {}}}", pairs.empty() ? "" : ", ", factor, clock);
    text += fmt::format("        .products = {{.factors = {{{}}}}},  // rows of [z; y] and of the clock\n", pairs);
  }
  if (has_fallback()) {
    const Fallback& fallback = network.fallback;
    text += fmt::format(
        "        .fallback = {{.outputs = {{{}}},\n"
        "                     .weights = {},\n"
        "                     .offset = {},\n"
        "                     .per_reach = {}}},\n",
        fmt::join(fallback.outputs, ", "), init.rows(fallback.rows, 12, field + ".fallback.rows"),
        init.vector(fallback.offset, field + ".fallback.offset"),
        init.vector(fallback.reach.cwiseInverse(), field + ".fallback.reach"));
  }
  return text + "    },\n";
}

std::string CppNetwork::description() const {
  std::string text = std::to_string(network.columns());
  for (const DenseLayer& dense : network.layers) text += fmt::format("-{}", dense.bias.size());
  text += network.layers.size() == 1
              ? ", linear"
              : " " + std::string(activation_row(activation_row(network.activation).trained_as).name);
  return text + (has_linear_path() ? " and a linear path" : "") + ", reads " + reads +
         (has_products() ? fmt::format(" and {} products with clocks", network.products.size()) : "") +
         (has_fallback() ? ", fallback rows for " + counted(std::to_string(network.fallback.outputs.size()), "state")
                         : "");
}

Eigen::Index CppNetwork::multiply_adds() const {
  Eigen::Index count =
      network.linear_path.size() + static_cast<Eigen::Index>(network.products.size()) + network.fallback.rows.size();
  for (const DenseLayer& dense : network.layers) count += dense.weights.size();
  return count;
}

Eigen::Index CppNetwork::activations() const {
  Eigen::Index count = -network.layers.back().bias.size();
  for (const DenseLayer& dense : network.layers) count += dense.bias.size();
  return count;
}

Eigen::Index CppNetwork::constant_bytes(const Initialiser& init) const {
  if (quantised) return packed_bytes(*quantised);
  const auto scalar = static_cast<Eigen::Index>(init.scalar_bytes()),
             one = static_cast<Eigen::Index>(init.weight_bytes());
  const Eigen::Index indices = 4 * static_cast<Eigen::Index>(network.products.size());  // two of 16 bits each
  Eigen::Index bytes = network.linear_path.size() * scalar + (indices + scalar - 1) / scalar * scalar;
  for (const DenseLayer& dense : network.layers)  // biases are aligned
    bytes += (dense.weights.size() * one + scalar - 1) / scalar * scalar + dense.bias.size() * scalar;
  if (has_fallback()) {
    const Fallback& fallback = network.fallback;
    const Eigen::Index outputs = 2 * fallback.rows.rows();  // an index of 16 bits each
    bytes += (fallback.rows.size() + 2 * fallback.rows.rows()) * scalar + (outputs + scalar - 1) / scalar * scalar;
  }
  if (error) bytes += (error->layer.weights.size() + 4 * error->layer.bias.size()) * scalar;
  return bytes;
}

}  // namespace nlo::codegen
