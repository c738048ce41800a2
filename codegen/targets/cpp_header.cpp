// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_header.h"

#include <fmt/format.h>

#include "codegen/error.h"
#include "codegen/fold.h"
#include "codegen/number.h"
#include "codegen/targets/generated_text.h"
#include "codegen/validate.h"

namespace nlo::codegen {
namespace {

/// All that the parts of the header are made from.
struct Source {
  const Model& model;
  FoldedModel folded;
  std::string name;
  Initialiser init;

  const FoldedNetwork& map() const { return folded.inverse_map; }
  bool has_linear_path() const { return map().linear_path.size() != 0; }
};

std::string joined(const std::vector<Channel>& channels, bool with_units) {
  std::string text;
  for (const Channel& channel : channels) {
    if (!text.empty()) text += ", ";
    text += channel.name;
    if (with_units && !channel.unit.empty()) text += " [" + safe_comment(channel.unit, 20) + "]";
  }
  return text;
}

std::string layer_names(const Source& s) {
  std::string text;
  for (std::size_t l = 1; l <= s.map().layers.size(); ++l)
    text += fmt::format("{}weights::kLayer{}", l > 1 ? ", " : "", l);
  return text;
}

std::string activation_of(const FoldedNetwork& n) {
  return n.activation == "tanh"   ? "Activation::kTanh"
         : n.activation == "relu" ? "Activation::kRelu"
                                  : "Activation::kSilu";
}

std::string hold_of(const Model& m) {
  return m.hold == "zero_order" ? "Hold::kZeroOrder" : m.hold == "rk4" ? "Hold::kRk4" : "Hold::kFirstOrder";
}

/// "3-50-50-2 tanh"
std::string network(const Source& s) {
  std::string text = std::to_string(s.map().inputs());
  for (const DenseLayer& layer : s.map().layers) text += fmt::format("-{}", layer.weights.rows());
  text += s.map().layers.size() == 1 ? ", linear" : " " + s.map().activation;
  return text + (s.has_linear_path() ? " and a linear path" : "");
}

std::string costs(const Source& s) {
  const Eigen::Index nz = s.model.nz(), ny = s.model.ny(), nx = s.model.nx();
  const Eigen::Index step = nz + 2 * s.model.pairs + 2 * nz * ny;
  Eigen::Index estimate = s.map().linear_path.size(), biases = 0;
  for (const DenseLayer& layer : s.map().layers) {
    estimate += layer.weights.size();
    biases += layer.bias.size();
  }
  // sizeof(Model): sample period; latent: eigenvalues, F, A, B0, B1, S, initial; output range; domain; the map. Each of
  // stale_after, hold and starts_steady takes a scalar's room, by alignment.
  const Eigen::Index scalars =
      1 + nz + nz * ny + (nz + 2 * nz * ny) + nz * ny + nz + 3 * ny + 2 * nz + estimate + biases + 3;
  const auto bytes = static_cast<Eigen::Index>(s.init.scalar_bytes());
  const Eigen::Index ram = bytes * (1 + nz + ny + 1);  // pointer (32 bit, padded), z, y, flags
  return fmt::format(
      "// Cost\n"
      "//   step()      {} multiply-adds\n"
      "//   estimate()  {} multiply-adds, {} activations\n"
      "//   kModel      {} bytes of constants\n"
      "//   Observer    {} bytes of RAM where pointers have 32 bits\n",
      grouped(step), grouped(estimate), grouped(biases - nx), grouped(scalars * bytes), grouped(ram));
}

std::string facts(const Model& m) {
  constexpr std::size_t kLongestName = 28, kLongestFact = 84;
  std::string text;
  for (const auto& [name, fact] : m.provenance) {
    if (fact.find_first_of("\r\n") != std::string::npos) continue;  // a whole config: the model file has it
    text += fmt::format("//   {:<{}}  {}\n", safe_comment(name, kLongestName), kLongestName,
                        safe_comment(fact, kLongestFact));
  }
  return text.empty() ? "" : "// About the model\n" + text + "//\n";
}

std::string example(const Source& s) {
  std::string reads;
  for (const Channel& output : s.model.outputs)
    reads += fmt::format("{}read_{}()", reads.empty() ? "" : ", ", output.name);
  if (s.model.ny() > 1) reads = "{{" + reads + "}}";
  return fmt::format(
      "// Use\n"
      "//   #include \"{0}.h\"\n"
      "//   constinit static nlo::{0}::Observer observer{{nlo::{0}::kModel}};\n"
      "//\n"
      "//   void on_timer() {{  // every {1} s\n"
      "//     if (observer.step({2}) != nlo::StepStatus::kOk) note_fault(observer.status());\n"
      "//     if (!observer.in_domain()) return enter_safe_mode();\n"
      "//     const auto x_hat = observer.estimate();\n"
      "//     use(x_hat[nlo::{0}::State::{3}]);\n"
      "//   }}\n",
      s.name, literal(s.model.sample_period_s), reads, s.model.states.front().name);
}

std::string top_comment(const Source& s) {
  std::string options;
  if (s.init.scalar_bytes() == 8) options += " --scalar double";
  if (s.name != s.model.name) options += " --name " + s.name;
  return fmt::format(
             "// {0}: a learned state observer (Kazantzis-Kravaris/Luenberger), generated. Do not edit; make it again "
             "by\n"
             "//   nlo export model.json{1} -o {0}.h\n"
             "//\n"
             "// Estimates {2} from {3}, sampled every {4} s.\n"
             "// Latent state: {5} ({6} complex pairs), {7} hold. Inverse map T*: {8}, reads {9}.\n"
             "// Normalisation and features are folded into the layers.\n"
             "//\n",
             s.name, options, joined(s.model.states, true), joined(s.model.outputs, true),
             literal(s.model.sample_period_s), s.model.nz(), s.model.pairs, s.model.hold, network(s),
             s.folded.reads_output ? "[z; y]" : "z") +
         facts(s.model) + costs(s) + "//\n" + example(s);
}

std::string layer(const Source& s, std::size_t l) {
  const DenseLayer& dense = s.map().layers[l];
  const std::string reads = l == 0 ? (s.folded.reads_output ? "[z; y]" : "z") : fmt::format("layer {}", l);
  return fmt::format(
      "\n// {0} x {1}: one neuron per line, reads {2}.\n"
      "inline constexpr Dense<{3}, {1}, {0}> kLayer{4} = {{\n"
      "    .weights = {5},\n"
      "    .bias = {6},\n"
      "}};\n",
      dense.weights.rows(), dense.weights.cols(), reads, s.init.scalar_name(), l + 1,
      s.init.rows(dense.weights, 6, fmt::format("inverse_map.layers[{}].weights", l)),
      s.init.vector(dense.bias, fmt::format("inverse_map.layers[{}].bias", l)));
}

std::string types(const Source& s) {
  const std::string linear_path = s.has_linear_path() ? fmt::format(", LinearPath<{}, {}, {}>", s.init.scalar_name(),
                                                                    s.map().inputs(), s.model.nx())
                                                      : "";
  return fmt::format(
      "using Network = decltype(make_mlp<{}>({}));\n"
      "using Model = KklModel<{}, {}, {}, {}, {}, InverseMap<Network{}>>;  // n_x, n_y, n_z, complex pairs\n"
      "using Observer = KklObserver<Model>;\n",
      activation_of(s.map()), layer_names(s), s.init.scalar_name(), s.model.nx(), s.model.ny(), s.model.nz(),
      s.model.pairs, linear_path);
}

std::string model_constant(const Source& s) {
  const Model& m = s.model;
  const FoldedModel& f = s.folded;
  Eigen::VectorXd wrap(m.ny());
  for (int j = 0; j < m.ny(); ++j) wrap(j) = m.outputs[static_cast<std::size_t>(j)].wrap;

  std::string text = "inline constexpr Model kModel = {\n";
  text += fmt::format("    .sample_period_s = {},\n", s.init(m.sample_period_s, "sample_period_s"));
  text +=
      fmt::format("    .stale_after = {},  // held measurements: the fastest mode's time constant\n", f.stale_after);
  text += "    .latent = {\n";
  text += fmt::format("        .hold = {},\n", hold_of(m));
  text += fmt::format("        .eigenvalues = {},  // 1/s\n", s.init.vector(m.eigenvalues, "eigenvalues"));
  text += fmt::format("        .output_injection = {},\n", s.init.matrix(m.output_injection, "output_injection"));
  text += fmt::format("        .step = {{.a_minus_1 = {},\n", s.init.vector(f.step.a_minus_1, "A"));
  text += fmt::format("                 .b0 = {},\n", s.init.matrix(f.step.b0, "B0"));
  text += fmt::format("                 .b1 = {}}},\n", s.init.matrix(f.step.b1, "B1"));
  text += fmt::format("        .steady_gain = {},\n", s.init.matrix(f.steady_gain, "steady_gain"));
  text += fmt::format("        .initial = {},\n", s.init.vector(m.initial_latent, "initial_latent"));
  text += fmt::format("        .starts_steady = {},\n", m.starts_steady);
  text += "    },\n";
  text +=
      fmt::format("    .outputs = {{.min = {}, .max = {}, .wrap = {}}},\n", s.init.vector(m.output_min, "output_min"),
                  s.init.vector(m.output_max, "output_max"), s.init.vector(wrap, "wrap"));
  text += fmt::format("    .domain = {{.latent_min = {},\n", s.init.vector(m.latent_min, "latent_min"));
  text += fmt::format("               .latent_max = {}}},\n", s.init.vector(m.latent_max, "latent_max"));
  text +=
      fmt::format("    .inverse_map = {{\n        .mlp = make_mlp<{}>({}),\n", activation_of(s.map()), layer_names(s));
  if (s.has_linear_path())
    text += fmt::format("        .linear_path = {{.weights = {}}},\n",
                        s.init.rows(s.map().linear_path, 12, "inverse_map.skip"));
  return text + "    },\n};\n";
}

void check_rounding(const Model& m, ScalarType scalar) {
  if (scalar == ScalarType::kDouble) return;
  const auto rounded = [](double value) { return static_cast<float>(value); };
  if (!(rounded(m.sample_period_s) > 0.0F))
    throw Error("sample_period_s rounds to zero in float; export with scalar double");
  for (int j = 0; j < m.ny(); ++j)
    if (!(rounded(m.output_min(j)) < rounded(m.output_max(j))))
      throw Error(fmt::format("output_min[{0}] and output_max[{0}] are equal in float; export with scalar double", j));
}

}  // namespace

std::string cpp_header(const Model& model, const ExportOptions& options) {
  validate(model);
  if (structure(model) != "kkl")
    throw Error(fmt::format("the target cpp does not know {} observers yet; it exports kkl", structure(model)));
  check_rounding(model, options.scalar);
  const Source s{model, fold(model), export_name(model, options), Initialiser(options.scalar)};

  std::string text = top_comment(s);
  text += "#pragma once\n\n#include <nlo/kkl_observer.h>\n\n";
  text += fmt::format("namespace nlo::{} {{\n\n", s.name);
  text += "/// Positions in a measurement and in an estimate.\n";
  text += fmt::format("struct Output {{\n  enum : int {{ {} }};\n}};\n", joined(model.outputs, false));
  text += fmt::format("struct State {{\n  enum : int {{ {} }};\n}};\n\n", joined(model.states, false));
  text += "namespace weights {\n";
  for (std::size_t l = 0; l < s.map().layers.size(); ++l) text += layer(s, l);
  text += "\n}  // namespace weights\n\n";
  text += types(s) + "\n" + model_constant(s);
  text += fmt::format("\n}}  // namespace nlo::{}\n", s.name);
  return text;
}

}  // namespace nlo::codegen
