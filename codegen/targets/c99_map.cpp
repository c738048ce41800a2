// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "codegen/embedded_text.h"

namespace nlo::codegen {
namespace {

std::string table(const Initialiser& init, const std::string& name, const Eigen::MatrixXd& values,
                  const std::string& field) {
  return fmt::format("static const Scalar {}[{} * {}] = {};\n", name, values.rows(), values.cols(),
                     c99_rows(init, values, field));
}

std::string activation(const std::string& kind, const std::string& suffix) {
  const std::string tanh = filled(embedded_text("c99/tanh.c.in"), {{"F", suffix}});
  if (kind == "tanh") return tanh + "static Scalar activated(Scalar v) { return tanh_rational(v); }\n\n";
  if (kind == "relu")
    return fmt::format("static Scalar activated(Scalar v) {{ return v > 0.0{0} ? v : 0.0{0}; }}\n\n", suffix);
  return tanh + fmt::format(
                    "// silu: v sigmoid(v), with sigmoid(v) = (1 + tanh(v / 2)) / 2\n"
                    "static Scalar activated(Scalar v) {{\n"
                    "  const Scalar half = v * 0.5{};\n"
                    "  return half * tanh_rational(half) + half;\n"
                    "}}\n\n",
                    suffix);
}

constexpr const char* kHidden =
    "static void hidden(int inputs, int outputs, const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* "
    "out) {\n"
    "  dense(inputs, outputs, weights, bias, in, out);\n"
    "  for (int o = 0; o < outputs; ++o) out[o] = activated(out[o]);\n"
    "}\n\n";

}  // namespace

std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field) {
  std::string text = "{\n";
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const std::string row = init.vector(values.row(i), field);
    text += "    " + row.substr(1, row.size() - 2) + ",\n";
  }
  return text + "}";
}

std::string c99_map(const std::string& name, const FoldedModel& folded, const Initialiser& init,
                    const std::string& suffix) {
  const FoldedNetwork& map = folded.inverse_map;
  std::string text = "// T*: one neuron per line.\n", body;
  Eigen::Index widest = 0;
  std::string in = "in", here = "here", there = "there";
  for (std::size_t l = 0; l < map.layers.size(); ++l) {
    const DenseLayer& layer = map.layers[l];
    const std::string field = fmt::format("inverse_map.layers[{}]", l);
    text += table(init, fmt::format("kWeights{}", l + 1), layer.weights, field + ".weights");
    text += fmt::format("static const Scalar kBias{}[{}] = {};\n", l + 1, layer.bias.size(),
                        init.vector(layer.bias, field + ".bias"));
    const bool last = l + 1 == map.layers.size();
    body += fmt::format("  {}({}, {}, kWeights{}, kBias{}, {}, {});\n", last ? "dense" : "hidden", layer.weights.cols(),
                        layer.weights.rows(), l + 1, l + 1, in, last ? "x_hat" : here);
    in = here;
    std::swap(here, there);
    if (!last) widest = std::max(widest, layer.bias.size());
  }
  if (map.linear_path.size() != 0) {
    text += table(init, "kLinearPath", map.linear_path, "inverse_map.skip");
    body += fmt::format("  dense({}, {}, kLinearPath, x_hat, in, x_hat);\n", map.linear_path.cols(),
                        map.linear_path.rows());
  }
  text += "\n" + std::string(embedded_text("c99/dense.c.in")) + "\n";
  if (map.layers.size() > 1) text += activation(map.activation, suffix) + kHidden;

  text += fmt::format("void {0}_estimate(const {0}_observer* observer, {1} x_hat[{2}]) {{\n", name, init.scalar_name(),
                      map.layers.back().bias.size());
  if (folded.reads_output) {
    text += "  Scalar in[kNz + kNy];\n  copy(in, observer->z, kNz);\n  copy(in + kNz, observer->y, kNy);\n";
  } else {
    text += "  const Scalar* in = observer->z;\n";
  }
  // Two buffers, taken by turns: one per layer would be a kilobyte of stack.
  if (map.layers.size() > 1) text += fmt::format("  Scalar here[{}]", widest);
  if (map.layers.size() > 2) text += fmt::format(", there[{}]", widest);
  if (map.layers.size() > 1) text += ";\n";
  return text + body + "}\n";
}

}  // namespace nlo::codegen
