// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_network.h"

#include <fmt/format.h>

namespace nlo::codegen {
namespace {

std::string activation_of(const FoldedNetwork& n) {
  return n.activation == "tanh"   ? "Activation::kTanh"
         : n.activation == "relu" ? "Activation::kRelu"
                                  : "Activation::kSilu";
}

std::string made(const CppNetwork& n) {
  std::string text = "make_mlp<" + activation_of(n.network) + ">(";
  for (std::size_t l = 1; l <= n.network.layers.size(); ++l)
    text += fmt::format("{}weights::k{}{}", l > 1 ? ", " : "", n.layer, l);
  return text + ")";
}

}  // namespace

std::string CppNetwork::layers(const Initialiser& init) const {
  std::string text;
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    const DenseLayer& dense = network.layers[l];
    text += fmt::format(
        "\n// {0} x {1}: one neuron per line, reads {2}.\n"
        "inline constexpr Dense<{3}, {1}, {0}> k{4}{5} = {{\n"
        "    .weights = {6},\n"
        "    .bias = {7},\n"
        "}};\n",
        dense.weights.rows(), dense.weights.cols(), l == 0 ? reads : fmt::format("layer {}", l), init.scalar_name(),
        layer, l + 1, init.rows(dense.weights, 6, fmt::format("{}.layers[{}].weights", field, l)),
        init.vector(dense.bias, fmt::format("{}.layers[{}].bias", field, l)));
  }
  return text;
}

std::string CppNetwork::using_declaration() const {
  return fmt::format("using {} = decltype({});\n", type, made(*this));
}

std::string CppNetwork::map_type(const Initialiser& init) const {
  const Eigen::Index out = network.layers.back().bias.size();
  const std::string path =
      has_linear_path() ? fmt::format(", LinearPath<{}, {}, {}>", init.scalar_name(), network.inputs(), out) : "";
  return map + "<" + type + path + ">";
}

std::string CppNetwork::initialiser(const Initialiser& init, const std::string& member) const {
  std::string text = fmt::format("    .{} = {{\n        .mlp = {},\n", member, made(*this));
  if (has_linear_path())
    text +=
        fmt::format("        .linear_path = {{.weights = {}}},\n", init.rows(network.linear_path, 12, field + ".skip"));
  return text + "    },\n";
}

std::string CppNetwork::description() const {
  std::string text = std::to_string(network.inputs());
  for (const DenseLayer& dense : network.layers) text += fmt::format("-{}", dense.bias.size());
  text += network.layers.size() == 1 ? ", linear" : " " + network.activation;
  return text + (has_linear_path() ? " and a linear path" : "") + ", reads " + reads;
}

Eigen::Index CppNetwork::multiply_adds() const {
  Eigen::Index count = network.linear_path.size();
  for (const DenseLayer& dense : network.layers) count += dense.weights.size();
  return count;
}

Eigen::Index CppNetwork::activations() const {
  Eigen::Index count = -network.layers.back().bias.size();
  for (const DenseLayer& dense : network.layers) count += dense.bias.size();
  return count;
}

Eigen::Index CppNetwork::scalars() const {
  return multiply_adds() + activations() + network.layers.back().bias.size();
}

}  // namespace nlo::codegen
