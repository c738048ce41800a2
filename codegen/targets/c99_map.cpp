// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_map.h"

#include <fmt/format.h>

#include <nlo/kernels/activation.h>
#include <nlo/kernels/int16.h>
#include <algorithm>
#include <utility>

#include "codegen/base/embedded_text.h"
#include "codegen/model/activations.h"
#include "codegen/model/checks.h"
#include "codegen/targets/c99_readings.h"

namespace nlo::codegen {
namespace {

std::string table(const Initialiser& init, const std::string& name, const Eigen::MatrixXd& values,
                  const std::string& field) {
  return fmt::format("static const IN_FLASH Scalar {}[{} * {}] = {};\n", name, values.rows(), values.cols(),
                     c99_rows(init, values, field));
}

/// `static Scalar tanh_rational(Scalar)`: the runtime's fit for the scalar.
std::string tanh_text(const Initialiser& init, const std::string& suffix) {
  if (init.scalar_bytes() == 4) return filled(embedded_text("c99/tanh.c.in"), {{"F", suffix}});
  constexpr const auto& kFit = kTanhFit<Activation::kTanh, double>;
  static_assert(kFit.kTerms == 10 && kFit.limit == 18.0, "the template has these");
  const auto terms = [&init](const double(&c)[kFit.kTerms]) {
    return init.vector(Eigen::Map<const Eigen::VectorXd>(c, kFit.kTerms), "tanh");
  };
  return filled(embedded_text("c99/tanh_double.c.in"), {{"P", terms(kFit.p)}, {"Q", terms(kFit.q)}});
}

/// The body of `activated`, for every activation whose row says that C99 has it.
std::string activation(Activation kind, const std::string& suffix) {
  switch (kind) {
    case Activation::kTanh:
      return "";
    case Activation::kRelu:
      return fmt::format("static Scalar activated(Scalar v) {{ return (v > 0.0{0}) ? v : 0.0{0}; }}\n\n", suffix);
    case Activation::kSilu:
      return fmt::format(
          "// silu: v sigmoid(v), with sigmoid(v) = (1 + tanh(v / 2)) / 2\n"
          "static Scalar activated(Scalar v) {{\n"
          "  const Scalar half = v * 0.5{};\n"
          "  return (half * tanh_rational(half)) + half;\n"
          "}}\n\n",
          suffix);
    case Activation::kTanh5e6:
    case Activation::kTanh5e5:
      break;
  }
  fail("C99 has no {}; export with --target cpp", activation_row(kind).name);
}

std::string hidden(Activation kind) {
  return fmt::format(
      "static void hidden(int inputs, int outputs, const IN_FLASH Scalar* weights, const IN_FLASH Scalar* bias,\n"
      "                   const Scalar* in, Scalar* out) {{\n"
      "  dense(inputs, outputs, weights, bias, in, out);\n"
      "  for (int o = 0; o < outputs; ++o) {{ out[o] = {}(out[o]); }}\n"
      "}}\n\n",
      kind == Activation::kTanh ? "tanh_rational" : "activated");
}

/// Adds the linear path's share of output `o` to `total`.
std::string add_linear_path(Eigen::Index inputs) {
  return fmt::format("for (int i = 0; i < {0}; ++i) {{ total += kLinearPath[({0} * o) + i] * in[i]; }}\n", inputs);
}

/// Integers of whatever type as an initialiser, `columns` to a line.
template <class Values>
std::string integers(const Values& values, std::size_t columns) {
  std::string text = "{";
  std::size_t i = 0;
  for (const auto value : values) text += (i++ % columns == 0 ? "\n    " : " ") + std::to_string(value) + ",";
  return text + "\n}";
}

std::string integer_activation(Activation kind) {
  if (kind == Activation::kRelu)
    return "// relu in Q15.\n"
           "static int16_t activated(int32_t value) {\n"
           "  return (int16_t)((value > 32767) ? 32767 : ((value < 0) ? 0 : value));\n"
           "}\n\n";
  return filled(embedded_text("c99/int16_tanh.c.in"), {{"TABLE", integers(kernels::int16::kTanhTable, 16)}});
}

/// The head of NAME_estimate, up to where `in` is what T* reads.
std::string estimate_head(const std::string& name, const Model& m, const FoldedModel& folded, const Initialiser& init) {
  const bool reads_output = folded.inverse_map()->inputs() > m.nz();
  const std::string readings = c99_readings_size(m);
  std::string head(m.saturates() ? embedded_text("c99/saturated.c.in") : "");
  head += fmt::format("void {0}_estimate(const {0}_observer* observer, {1} x_hat[{2}]) {{\n", name, init.scalar_name(),
                      m.nx());
  if (!reads_output && !m.saturates()) return head + "  const Scalar* in = observer->z;\n";
  head += reads_output ? fmt::format("  Scalar in[kNz + {}];\n", readings) : "  Scalar in[kNz];\n";
  head += m.saturates() ? "  saturated(observer, in);\n" : "  copy(in, observer->z, kNz);\n";
  return head + (reads_output ? fmt::format("  copy(in + kNz, observer->y, {});\n", readings) : "");
}

}  // namespace

std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field) {
  std::string text = "{\n";
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const std::string row = init.vector(values.row(i), field);
    text += "    " + row.substr(1, row.size() - 2) + ",\n";
  }
  return text + "}";
}

std::string c99_arithmetic(const FoldedModel& folded, bool has_int16_map, const Initialiser& init,
                           const std::string& suffix) {
  const FoldedNetwork& map = *folded.inverse_map();
  const bool learned_step = folded.networks.size() > 1;
  if (has_int16_map && !learned_step) return "";
  const bool map_reads_tanh = !has_int16_map && map.layers.size() > 1 && map.activation != Activation::kRelu;
  return std::string(embedded_text("c99/dense.c.in")) + "\n" +
         (learned_step || map_reads_tanh ? tanh_text(init, suffix) + "\n" : "");
}

std::string c99_step_networks(const FoldedModel& folded, const Initialiser& init) {
  std::string text;
  for (const FoldedNetwork& n : folded.networks) {
    if (n.field == "inverse_map") continue;
    std::string name = n.field;  // gates: kGates, kGatesBias
    name.front() = static_cast<char>(name.front() - 'a' + 'A');
    const DenseLayer& layer = n.layers.front();
    text += table(init, "k" + name, layer.weights, n.field + ".layers[0].weights") +
            fmt::format("static const IN_FLASH Scalar k{}Bias[{}] = {};\n", name, layer.bias.size(),
                        init.vector(layer.bias, n.field + ".layers[0].bias"));
  }
  return text;
}

std::string c99_map(const std::string& name, const Model& m, const FoldedModel& folded, const Initialiser& init,
                    const std::string& suffix) {
  const FoldedNetwork& map = *folded.inverse_map();
  std::string text = "// T*: one neuron per line.\n", body;
  Eigen::Index widest = 0;
  std::string in = "in", ping = "ping", pong = "pong";
  for (std::size_t l = 0; l < map.layers.size(); ++l) {
    const DenseLayer& layer = map.layers[l];
    const std::string field = fmt::format("inverse_map.layers[{}]", l);
    text += table(init, fmt::format("kWeights{}", l + 1), layer.weights, field + ".weights");
    text += fmt::format("static const IN_FLASH Scalar kBias{}[{}] = {};\n", l + 1, layer.bias.size(),
                        init.vector(layer.bias, field + ".bias"));
    const bool last = l + 1 == map.layers.size();
    body += fmt::format("  {}({}, {}, kWeights{}, kBias{}, {}, {});\n", last ? "dense" : "hidden", layer.weights.cols(),
                        layer.weights.rows(), l + 1, l + 1, in, last ? "x_hat" : ping);
    in = ping;
    std::swap(ping, pong);
    if (!last) widest = std::max(widest, layer.bias.size());
  }
  if (map.linear_path.size() != 0) {
    text += table(init, "kLinearPath", map.linear_path, "inverse_map.skip");
    body += fmt::format(
        "  for (int o = 0; o < {}; ++o) {{\n    Scalar total = x_hat[o];\n    {}    x_hat[o] = total;\n  }}\n",
        map.linear_path.rows(), add_linear_path(map.linear_path.cols()));
  }
  text += "\n";
  if (map.layers.size() > 1) text += activation(map.activation, suffix) + hidden(map.activation);

  text += estimate_head(name, m, folded, init);
  // Ping-pong buffers: one for each layer would be a kilobyte of stack.
  if (map.layers.size() > 1) text += fmt::format("  Scalar ping[{}]", widest);
  if (map.layers.size() > 2) text += fmt::format(", pong[{}]", widest);
  if (map.layers.size() > 1) text += ";\n";
  return text + body + "}\n";
}

std::string c99_int16_map(const std::string& name, const Model& m, const FoldedModel& folded,
                          const QuantisedNetwork& map, const Initialiser& init) {
  std::string text = "// T* in int16: one neuron per line.\n", body;
  Eigen::Index widest = map.inputs(), most_sums = 0;
  for (std::size_t l = 0; l < map.layers.size(); ++l) {
    const QuantisedLayer& layer = map.layers[l];
    const Eigen::Index rows = layer.weights.rows(), columns = layer.weights.cols();
    const Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic> by_rows = layer.weights.transpose();
    text += fmt::format("static const IN_FLASH int16_t kWeights{}[{} * {}] = {};\n", l + 1, rows, columns,
                        integers(by_rows.reshaped(), static_cast<std::size_t>(columns)));
    text += fmt::format("static const IN_FLASH int32_t kBias{}[{}] = {};\n", l + 1, rows, integers(layer.bias, 8));
    const bool last = l + 1 == map.layers.size();
    body += fmt::format("  {0}({1}, {2}, {3}kWeights{4}, kBias{4}, values, sums);\n", last ? "integer_dense" : "hidden",
                        columns, rows, last ? "" : fmt::format("{}, ", layer.shift), l + 1);
    if (!last) widest = std::max(widest, rows);
    most_sums = std::max(most_sums, rows);
  }
  const Eigen::Index in = map.inputs(), out = map.outputs();
  text += fmt::format("static const IN_FLASH Scalar kCentre[{}] = {};\n", in,
                      init.vector(map.centre.cast<double>(), "latent_min"));
  text += fmt::format("static const IN_FLASH Scalar kGain[{}] = {};  // to +-32767\n", in,
                      init.vector(map.gain.cast<double>(), "latent_max"));
  text += fmt::format("static const IN_FLASH Scalar kScale[{}] = {};\n", out,
                      init.vector(map.scale.cast<double>(), "inverse_map.layers"));
  const bool linear = map.linear_path.size() != 0;
  if (linear) text += table(init, "kLinearPath", map.linear_path.cast<double>(), "inverse_map.skip");
  text += "\n" + std::string(embedded_text("c99/int16.c.in"));
  if (map.layers.size() > 1)
    text += integer_activation(map.activation) + std::string(embedded_text("c99/int16_hidden.c.in"));

  text += estimate_head(name, m, folded, init);
  text += fmt::format("  int16_t values[{}];\n  int32_t sums[{}];\n", widest, most_sums);
  text +=
      fmt::format("  for (int i = 0; i < {}; ++i) {{ values[i] = quantised(in[i] - kCentre[i], kGain[i]); }}\n", in) +
      body;
  text += fmt::format("  for (int o = 0; o < {}; ++o) {{\n    Scalar total = kScale[o] * (Scalar)sums[o];\n", out);
  if (linear) text += "    " + add_linear_path(in);
  return text + "    x_hat[o] = total;\n  }\n}\n";
}

}  // namespace nlo::codegen
