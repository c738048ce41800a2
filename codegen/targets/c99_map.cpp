// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlo/kernels/activation.h>
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "codegen/base/embedded_text.h"
#include "codegen/model/activations.h"
#include "codegen/model/field_checks.h"
#include "codegen/targets/c99_integers.h"
#include "codegen/targets/c99_readings.h"

namespace nlo::codegen {
namespace {

std::string table(const Initialiser& init, const std::string& name, const Eigen::MatrixXd& values,
                  const std::string& field) {
  return fmt::format("static const IN_FLASH Scalar {}[{}] = {};\n", name, c99_table_size(values.rows(), values.cols()),
                     c99_rows(init, values, field));
}

/// Returns the text of `static Scalar tanh_rational(Scalar)` with the runtime's fit for the scalar.
std::string tanh_text(const Initialiser& init, const std::string& suffix) {
  if (init.scalar_bytes() == 4) return filled(embedded_text("c99/tanh.c.in"), {{"F", suffix}});
  constexpr const auto& kFit = kTanhFit<Activation::kTanh, double>;
  static_assert(kFit.kTerms == 10 && kFit.limit == 18.0, "the template has these");
  const auto terms = [&init](const double(&c)[kFit.kTerms]) {
    return init.vector(Eigen::Map<const Eigen::VectorXd>(c, kFit.kTerms), "tanh");
  };
  return filled(embedded_text("c99/tanh_double.c.in"), {{"P", terms(kFit.p)}, {"Q", terms(kFit.q)}});
}

/// Returns the keys of layer.c.in and tangent.c.in. Throws Error if C99 does not have the activation.
std::map<std::string, std::string> activation_values(Activation kind, const std::string& suffix) {
  const ActivationRow& row = activation_row(kind);
  if (!row.has_c99) fail("C99 has no {}; export with --target cpp", row.name);
  const std::string name(row.name);
  const auto if_it_is = [kind](Activation other) { return kind == other ? "true" : ""; };
  return {{"F", suffix},
          {"ACTIVATION", name},
          {"FUNCTION", kind == Activation::kTanh ? "tanh_rational" : name},
          {"TANH", if_it_is(Activation::kTanh)},
          {"RELU", if_it_is(Activation::kRelu)},
          {"SILU", if_it_is(Activation::kSilu)}};
}

/// Returns the text that adds the linear path of output `o` to `total`.
std::string add_linear_path(const std::string& prefix, Eigen::Index inputs, const std::string& in) {
  return fmt::format("for (int i = 0; i < {0}; ++i) {{ total += k{1}LinearPath[({0} * o) + i] * {2}[i]; }}\n", inputs,
                     prefix, in);
}

/// Returns the tables of the rows that states fall back to.
std::string fallback_tables(const FoldedNetwork& map, const Initialiser& init) {
  const Fallback& fallback = map.fallback;
  if (fallback.outputs.empty()) return "";
  const auto vector = [&](const char* name, const Eigen::VectorXd& values, const std::string& field) {
    return fmt::format("static const IN_FLASH Scalar {}[{}] = {};\n", name, values.size(),
                       init.vector(values, map.field + ".fallback." + field));
  };
  return fmt::format(
             "// Linear rows that states fall back to where T* is far from them.\n"
             "static const IN_FLASH uint16_t kFallbackOutputs[{}] = {{{}}};\n",
             fallback.outputs.size(), fmt::join(fallback.outputs, ", ")) +
         table(init, "kFallbackRows", fallback.rows, map.field + ".fallback.rows") +
         vector("kFallbackOffset", fallback.offset, "offset") +
         vector("kFallbackPerReach", fallback.reach.cwiseInverse(), "reach");
}

/// Returns the code that corrects `x_hat`, the value of T* at `in`.
std::string fallback_code(const FoldedNetwork& map) {
  if (map.fallback.outputs.empty()) return "";
  return fmt::format(
      "  for (int f = 0; f < {}; ++f) {{\n"
      "    Scalar row = kFallbackOffset[f];\n"
      "    for (int i = 0; i < {}; ++i) {{ row += kFallbackRows[({} * f) + i] * in[i]; }}\n"
      "    const Scalar apart = x_hat[kFallbackOutputs[f]] - row;\n"
      "    const Scalar ratio = apart * kFallbackPerReach[f];\n"
      "    x_hat[kFallbackOutputs[f]] = row + apart / ((Scalar)1 + ratio * ratio);\n"
      "  }}\n",
      map.fallback.outputs.size(), map.columns(), map.columns());
}

/// A folded network in C99: its tables, and the calls that evaluate it.
struct NetworkText {
  std::string tables, calls;
};

/// Writes a network in C99. Its tables are called kPREFIX and so on. `calls` read `in` and write `out`; with `tangent`
/// they write the derivative along `direction`.
NetworkText network_text(const std::string& prefix, const FoldedNetwork& n, const std::string& out, bool tangent,
                         const Initialiser& init) {
  const auto along = [](const std::string& value) { return value == "in" ? "direction" : value + "_tangent"; };
  const auto at = [&](const std::string& value) { return tangent ? value + ", " + along(value) : value; };
  NetworkText text;
  Eigen::Index widest = 0;
  std::string in = "in", ping = "ping", pong = "pong";
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const DenseLayer& layer = n.layers[l];
    const bool last = l + 1 == n.layers.size();
    const std::string field = fmt::format("{}.layers[{}]", n.field, l);
    const std::string weights = fmt::format("k{}Weights{}", prefix, l + 1);
    const std::string bias = tangent && last ? "kNoBias" : fmt::format("k{}Bias{}", prefix, l + 1);
    text.tables += table(init, weights, layer.weights, field + ".weights");
    if (bias != "kNoBias")
      text.tables += fmt::format("static const IN_FLASH Scalar {}[{}] = {};\n", bias, layer.bias.size(),
                                 init.vector(layer.bias, field + ".bias"));
    const std::string hidden = tangent ? "tangent" : std::string(activation_row(n.activation).name);
    text.calls +=
        fmt::format("  {}({}, {}, {}, {}, {}, {});\n", last ? "dense" : hidden + "_layer", layer.weights.cols(),
                    layer.weights.rows(), weights, bias, last && tangent ? along(in) : at(in), last ? out : at(ping));
    in = ping;
    std::swap(ping, pong);
    if (!last) widest = std::max(widest, layer.bias.size());
  }
  // Two buffers in turn: one buffer per layer would take a kilobyte of stack.
  std::string buffers;
  for (std::size_t l = 1; l < std::min<std::size_t>(n.layers.size(), 3); ++l) {
    const std::string buffer = l == 1 ? "ping" : "pong";
    buffers += fmt::format("{}{}[{}]", l == 1 ? "  Scalar " : ", ", buffer, widest);
    if (tangent) buffers += fmt::format(", {}[{}]", along(buffer), widest);
  }
  if (!buffers.empty()) text.calls.insert(0, buffers + ";\n");
  if (n.linear_path.size() != 0) {
    text.tables += table(init, "k" + prefix + "LinearPath", n.linear_path, n.field + ".skip");
    text.calls += fmt::format(
        "  for (int o = 0; o < {0}; ++o) {{\n    Scalar total = {1}[o];\n    {2}    {1}[o] = total;\n  }}\n",
        n.linear_path.rows(), out, add_linear_path(prefix, n.linear_path.cols(), tangent ? "direction" : "in"));
  }
  return text;
}

/// Returns the name of the function of a network, such as `forward_map` for drive.forward_map.
std::string function_name(const FoldedNetwork& n) {
  return n.field.substr(n.field.rfind('.') + 1);
}
std::string table_prefix(const FoldedNetwork& n) {
  std::string name;
  bool upper = true;
  for (const char c : function_name(n)) {
    if (c != '_') name += upper ? static_cast<char>(c - 'a' + 'A') : c;
    upper = c == '_';
  }
  return name;
}

bool is_map(const FoldedNetwork& n) {
  return n.field == "inverse_map";
}

/// Returns the table of the products with clocks that T* reads behind its inputs: the row of each factor.
std::string product_table(const FoldedNetwork& map) {
  if (map.products.empty()) return "";
  std::string rows;
  for (const auto& [factor, clock] : map.products)
    rows += fmt::format("{}{{{}, {}}}", rows.empty() ? "" : ", ", factor, clock);
  return fmt::format(
      "// T* also reads the products in[a] in[b]. in[b] is a clock exp(-t / tau): it falls from 1 at the start to 0.\n"
      "static const IN_FLASH uint16_t kProducts[{}][2] = {{{}}};\n",
      map.products.size(), rows);
}

/// Returns the head of NAME_estimate, up to the point where `in` has the inputs of T*.
std::string estimate_head(const std::string& name, const Model& m, const FoldedModel& folded, const Initialiser& init) {
  const FoldedNetwork* map = folded.inverse_map();
  const bool reads_output = map != nullptr && map->inputs() > m.nz();
  const std::size_t products = map == nullptr ? 0 : map->products.size();
  const std::string readings = c99_readings_size(m);
  std::string head(m.saturates() ? embedded_text("c99/saturated.c.in") : "");
  head += fmt::format("void {0}_estimate(const {0}_observer* observer, {1} x_hat[{2}]) {{\n", name, init.scalar_name(),
                      m.nx());
  if (!reads_output && !m.saturates() && products == 0) return head + "  const Scalar* in = observer->z;\n";
  const std::string own = reads_output ? fmt::format("kNz + {}", readings) : "kNz";
  head += fmt::format("  Scalar in[{}{}];\n", own, products > 0 ? fmt::format(" + {}", products) : "");
  head += m.saturates() ? "  saturated(observer, in);\n" : "  copy(in, observer->z, kNz);\n";
  if (reads_output) head += fmt::format("  copy(in + kNz, observer->y, {});\n", readings);
  if (products > 0)
    head +=
        fmt::format("  for (int i = 0; i < {}; ++i) {{ in[{} + i] = in[kProducts[i][0]] * in[kProducts[i][1]]; }}\n",
                    products, own);
  return head;
}

}  // namespace

std::string c99_table_size(Eigen::Index rows, Eigen::Index columns) {
  return rows == 1 ? fmt::format("{}", columns) : fmt::format("{} * {}", rows, columns);
}

std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field) {
  std::string text = "{\n";
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const std::string row = init.vector(values.row(i), field);
    text += "    " + row.substr(1, row.size() - 2) + ",\n";
  }
  return text + "}";
}

std::string c99_arithmetic(const FoldedModel& folded, const QuantisedModel* quantised, bool steps_with_tanh,
                           const Initialiser& init, const std::string& suffix) {
  const bool integer_step = quantised != nullptr && quantised->units;
  std::set<Activation> kinds;
  bool evaluates = false;
  for (const FoldedNetwork& n : folded.networks) {
    if (quantised != nullptr && (is_map(n) || integer_step)) continue;
    evaluates = true;
    if (n.layers.size() > 1) kinds.insert(n.activation);
  }
  if (!evaluates) return integer_step ? c99_integer_arithmetic(*quantised) : "";
  std::string text(embedded_text("c99/dense.c.in"));
  if (steps_with_tanh || kinds.contains(Activation::kTanh) || kinds.contains(Activation::kSilu))
    text += "\n" + tanh_text(init, suffix);
  for (const Activation kind : kinds)
    text += "\n" + filled(embedded_text("c99/layer.c.in"), activation_values(kind, suffix));
  return text + "\n";
}

std::string c99_step_networks(const FoldedModel& folded, const QuantisedModel* quantised, const Initialiser& init) {
  std::string text;
  if (quantised != nullptr && quantised->units) {
    const auto& [gates, candidate] = *quantised->units;
    text += fmt::format("static const IN_FLASH Scalar kReadingCentre[{}] = {};\n", gates.centre.size(),
                        init.vector(gates.centre.cast<double>(), "output_min"));
    text += fmt::format("static const IN_FLASH Scalar kReadingGain[{}] = {};  // to +-32767\n", gates.gain.size(),
                        init.vector(gates.gain.cast<double>(), "output_max"));
    return text + c99_integer_tables(gates.layers.front(), "kGates", "kGatesBias") +
           c99_integer_tables(candidate.layers.front(), "kCandidate", "kCandidateBias");
  }
  for (const FoldedNetwork& n : folded.networks) {
    if (is_map(n)) continue;
    const std::string name = table_prefix(n);  // gates: kGates, kGatesBias
    const DenseLayer& layer = n.layers.front();
    text += table(init, "k" + name, layer.weights, n.field + ".layers[0].weights") +
            fmt::format("static const IN_FLASH Scalar k{}Bias[{}] = {};\n", name, layer.bias.size(),
                        init.vector(layer.bias, n.field + ".layers[0].bias"));
  }
  return text;
}

std::string c99_functions(const FoldedModel& folded, const Initialiser& init) {
  std::string text;
  for (const FoldedNetwork& n : folded.networks) {
    if (is_map(n)) continue;
    const NetworkText network = network_text(table_prefix(n), n, "out", false, init);
    text += network.tables +
            fmt::format("static void {}(const Scalar* in, Scalar* out) {{\n{}}}\n\n", function_name(n), network.calls);
  }
  return text;
}

std::string c99_tangents(const FoldedModel& folded, const Initialiser& init, const std::string& suffix) {
  std::string text;
  for (const FoldedNetwork& n : folded.networks) {
    if (is_map(n)) continue;
    std::map<std::string, std::string> values = activation_values(n.activation, suffix);
    Eigen::Index widest = 0;
    for (const DenseLayer& layer : n.layers) widest = std::max(widest, layer.bias.size());
    values["WIDEST"] = std::to_string(widest);
    values["NO_BIAS"] = init.vector(Eigen::VectorXd::Zero(widest), "");
    values["LAYERED"] = n.layers.size() > 1 ? "true" : "";
    const NetworkText network = network_text(table_prefix(n), n, "out", true, init);
    text += filled(embedded_text("c99/tangent.c.in"), values) + network.tables +
            fmt::format("static void {}_tangent(const Scalar* in, const Scalar* direction, Scalar* out) {{\n{}{}}}\n\n",
                        function_name(n), n.layers.size() > 1 ? "" : "  (void)in;\n", network.calls);
  }
  return text;
}

std::string c99_map(const std::string& name, const Model& m, const FoldedModel& folded, const Initialiser& init) {
  if (folded.inverse_map() == nullptr)  // z is the estimate
    return estimate_head(name, m, folded, init) + "  copy(x_hat, in, kNx);\n}\n";
  const NetworkText text = network_text("", *folded.inverse_map(), "x_hat", false, init);
  return "// Weights of T*, one neuron per line.\n" + text.tables + product_table(*folded.inverse_map()) +
         fallback_tables(*folded.inverse_map(), init) + "\n" + estimate_head(name, m, folded, init) + text.calls +
         fallback_code(*folded.inverse_map()) + "}\n";
}

std::string c99_int16_map(const std::string& name, const Model& m, const FoldedModel& folded,
                          const QuantisedModel& quantised, const Initialiser& init) {
  const QuantisedNetwork& map = quantised.map;
  std::string text = "// Weights of T* in int16, one neuron per line.\n", body;
  Eigen::Index widest = map.columns(), most_sums = 0;
  for (std::size_t l = 0; l < map.layers.size(); ++l) {
    const QuantisedLayer& layer = map.layers[l];
    const Eigen::Index rows = layer.weights.rows(), columns = layer.weights.cols();
    text += c99_integer_tables(layer, fmt::format("kWeights{}", l + 1), fmt::format("kBias{}", l + 1));
    const bool last = l + 1 == map.layers.size();
    body += fmt::format("  {0}({1}, {2}, {3}kWeights{4}, kBias{4}, values, sums);\n", last ? "integer_dense" : "hidden",
                        columns, rows, last ? "" : fmt::format("{}, ", layer.shift), l + 1);
    if (!last) widest = std::max(widest, rows);
    most_sums = std::max(most_sums, rows);
  }
  const Eigen::Index in = map.columns(), out = map.outputs();
  text += fmt::format("static const IN_FLASH Scalar kCentre[{}] = {};\n", in,
                      init.vector(map.centre.cast<double>(), "latent_min"));
  text += fmt::format("static const IN_FLASH Scalar kGain[{}] = {};  // to +-32767\n", in,
                      init.vector(map.gain.cast<double>(), "latent_max"));
  text += fmt::format("static const IN_FLASH Scalar kScale[{}] = {};\n", out,
                      init.vector(map.scale.cast<double>(), "inverse_map.layers"));
  const bool linear = map.linear_path.size() != 0;
  if (linear) text += table(init, "kLinearPath", map.linear_path.cast<double>(), "inverse_map.skip");
  text += product_table(*folded.inverse_map()) + fallback_tables(*folded.inverse_map(), init) + "\n";
  if (!quantised.units) text += c99_integer_arithmetic(quantised);  // gated units write it before the step

  text += estimate_head(name, m, folded, init);
  text += fmt::format("  int16_t values[{}];\n  int32_t sums[{}];\n", widest, most_sums);
  text +=
      fmt::format("  for (int i = 0; i < {}; ++i) {{ values[i] = quantised(in[i] - kCentre[i], kGain[i]); }}\n", in) +
      body;
  text += fmt::format("  for (int o = 0; o < {}; ++o) {{\n    Scalar total = kScale[o] * (Scalar)sums[o];\n", out);
  if (linear) text += "    " + add_linear_path("", in, "in");
  return text + "    x_hat[o] = total;\n  }\n" + fallback_code(*folded.inverse_map()) + "}\n";
}

}  // namespace nlo::codegen
