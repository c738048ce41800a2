// SPDX-License-Identifier: MIT
#include "codegen/targets/c99.h"

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "codegen/embedded_text.h"
#include "codegen/error.h"
#include "codegen/fold.h"
#include "codegen/number.h"
#include "codegen/number_formats.h"
#include "codegen/quantise.h"
#include "codegen/targets/c99_map.h"
#include "codegen/targets/cpp_structure.h"
#include "codegen/targets/export_parts.h"
#include "codegen/targets/generated_text.h"
#include "codegen/validate.h"

namespace nlo::codegen {
namespace {

/// `rig_output_alpha, rig_output_load`
std::string positions(const std::string& prefix, const std::vector<Channel>& channels) {
  std::string text;
  for (const Channel& channel : channels) text += (text.empty() ? "" : ", ") + prefix + channel.name;
  return text;
}

std::string tables(const Model& m, const FoldedModel& folded, const Initialiser& init) {
  const auto vector = [&](const char* name, const char* size, const Eigen::VectorXd& values, const char* field) {
    return fmt::format("static const Scalar {}[{}] = {};\n", name, size, init.vector(values, field));
  };
  const auto matrix = [&](const char* name, const Eigen::MatrixXd& values, const char* field) {
    return fmt::format("static const Scalar {}[kNz][kNy] = {};\n", name, init.matrix(values, field));
  };
  Eigen::VectorXd wrap(m.ny());
  std::string relative;
  for (int j = 0; j < m.ny(); ++j) {
    wrap(j) = m.outputs[static_cast<std::size_t>(j)].wrap;
    relative += fmt::format("{}{}", j == 0 ? "" : ", ", is_relative(m, j));
  }
  return fmt::format("static const Recurrence kStep = {{  // over one sample period\n    {},\n    {},\n    {}}};\n",
                     init.vector(folded.step.a_minus_1, "A"), init.matrix(folded.step.b0, "B0"),
                     init.matrix(folded.step.b1, "B1")) +
         "\n// D [1/s], F, the steady state S y of a constant y, and z before the first measurement.\n" +
         vector("kEigenvalues", "kNz", m.eigenvalues, "eigenvalues") +
         matrix("kOutputInjection", m.output_injection, "output_injection") +
         matrix("kSteadyGain", folded.steady_gain, "steady_gain") +
         vector("kInitial", "kNz", m.initial_latent, "initial_latent") +
         vector("kNoOutput", "kNy", Eigen::VectorXd::Zero(m.ny()), "") +
         "\n// What a measurement may be; a full turn of an angle, or 0. The box that training has filled: of z, less "
         "S y for\n"
         "// relative outputs.\n" +
         vector("kOutputMin", "kNy", m.output_min, "output_min") +
         vector("kOutputMax", "kNy", m.output_max, "output_max") + vector("kWrap", "kNy", wrap, "wrap") +
         fmt::format("static const bool kRelative[kNy] = {{{}}};\n", relative) +
         vector("kLatentMin", "kNz", m.latent_min, "latent_min") +
         vector("kLatentMax", "kNz", m.latent_max, "latent_max");
}

std::string example(const Model& m, const std::string& name, const char* scalar) {
  std::string reads;
  for (const Channel& channel : m.outputs) reads += fmt::format("{}read_{}()", reads.empty() ? "" : ", ", channel.name);
  return fmt::format(
      "// Use\n"
      "//   #include \"{0}.h\"\n"
      "//   static {0}_observer observer;  // {0}_init(&observer) at start\n"
      "//\n"
      "//   void on_timer(void) {{  // every {1} s\n"
      "//     const {4} y[{0}_NY] = {{{2}}};\n"
      "//     {4} x_hat[{0}_NX];\n"
      "//     if ({0}_step(&observer, y) != {0}_OK) note_fault({0}_last_status(&observer));\n"
      "//     if (!{0}_in_domain(&observer)) {{ enter_safe_mode(); return; }}\n"
      "//     {0}_estimate(&observer, x_hat);\n"
      "//     use(x_hat[{0}_state_{3}]);\n"
      "//   }}\n",
      name, literal(m.sample_period_s), reads, m.states.front().name, scalar);
}

}  // namespace

void check_c99(const Model& m) {
  if (structure(m) != "kkl")
    throw Error(fmt::format("\"{}\" is a {} observer; target c99 writes kkl observers: export it with --target cpp",
                            m.name, structure(m)));
}

std::vector<NamedText> c99(const Model& m, const ExportOptions& options) {
  validate(m);
  const std::string name = export_name(m, options);
  check_c99(m);
  check_weights(options, "c99");
  check_rounding(m, options.scalar);
  const FoldedModel folded = fold(m);
  const Initialiser init(options);
  std::optional<QuantisedNetwork> quantised;
  if (options.scalar == ScalarType::kInt16) quantised = quantise(m, folded);
  const std::unique_ptr<CppStructure> parts = cpp_structure(m, folded, init, quantised ? &*quantised : nullptr);
  const bool single = options.scalar != ScalarType::kDouble;
  const std::string suffix = single ? "f" : "";

  const std::string map =
      quantised ? c99_int16_map(name, folded, *quantised, init) : c99_map(name, folded, init, suffix);
  std::map<std::string, std::string> values = {
      {"NAME", name},
      {"SCALAR", init.scalar_name()},
      {"F", suffix},
      {"BITS", single ? "uint32_t" : "uint64_t"},
      {"EXPONENT", single ? "0x7f800000U" : "0x7ff0000000000000U"},
      {"LARGEST", single ? literal(0x1p100F) : literal(0x1p100)},
      {"TINY", single ? literal(0x1p-100F) : literal(0x1p-100)},
      {"NX", std::to_string(m.nx())},
      {"NY", std::to_string(m.ny())},
      {"NZ", std::to_string(m.nz())},
      {"PAIRS", std::to_string(m.pairs)},
      {"FIRST_ORDER", m.hold == "zero_order" ? "0" : "1"},
      {"STARTS_STEADY", m.starts_steady ? "1" : "0"},
      {"STALE_AFTER", std::to_string(folded.stale_after)},
      {"SAMPLE_PERIOD", init(m.sample_period_s, "sample_period_s")},
      {"OUTPUTS", positions(name + "_output_", m.outputs)},
      {"STATES", positions(name + "_state_", m.states)},
      {"STEP_COST", with_activations(parts->step_multiply_adds(), parts->step_activations())},
      {"ESTIMATE_COST", with_activations(parts->estimate_multiply_adds(), parts->estimate_activations())},
      {"TABLES", tables(m, folded, init)},
      {"MAP", map},
  };
  values["TOP"] = "";
  std::uint32_t hash = 0x811c9dc5U;  // FNV-1a of all that the two must agree on
  for (const auto& [key, value] : values)
    for (const char c : value) hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193U;
  values["EXPORT"] = fmt::format("0x{:08x}", hash);

  std::string flags;
  if (options.scalar != ScalarType::kFloat) flags += fmt::format(" --scalar {}", scalar_name(options.scalar));
  if (name != m.name) flags += " --name " + name;
  const std::size_t bytes = init.scalar_bytes(), state = bytes * static_cast<std::size_t>(m.nz() + m.ny()) + 4;
  values["TOP"] =
      fmt::format(
          "// {0}: {1} in C99, generated. Do not edit; make it again by\n"
          "//   nlo export model.json --target c99{2} -o {0}.h\n"
          "//\n"
          "// Estimates {3} from {4}, sampled every {5} s.\n",
          name, parts->title(), flags, channel_list(m.states, true), channel_list(m.outputs, true),
          literal(m.sample_period_s)) +
      parts->description() +
      "// Normalisation and features are folded into the layers. The same bits on every IEEE 754 target, compiler "
      "and\n// optimisation level (but not with -ffast-math, or clang's -ffp-contract=fast).\n" +
      (quantised ? arithmetic_note(m, options) : "") + "//\n" + facts(m) +
      fmt::format("// {0}_observer takes {1} bytes of RAM; the tables are constants. No heap, no library.\n//\n", name,
                  (state + bytes - 1) / bytes * bytes) +
      example(m, name, init.scalar_name());
  return {{name + ".h", filled(embedded_text("c99/observer.h.in"), values)},
          {name + ".c", filled(embedded_text("c99/observer.c.in"), values)}};
}

}  // namespace nlo::codegen
