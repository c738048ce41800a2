// SPDX-License-Identifier: MIT
#include "codegen/targets/c99.h"

#include <fmt/format.h>
#include <nlo/latent.h>

#include <cstdint>
#include <limits>
#include <map>
#include <memory>

#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/number.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/c99_map.h"
#include "codegen/targets/c99_monitor.h"
#include "codegen/targets/c99_readings.h"
#include "codegen/targets/export_parts.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

std::string example(const Model& m, const std::string& name, const char* scalar) {
  std::string reads;
  for (const Channel& channel : measured_channels(m))
    reads += fmt::format("{}read_{}()", reads.empty() ? "" : ", ", channel.name);
  std::string commands;
  for (const Channel& channel : inputs(m))
    commands += fmt::format("{}command_{}()", commands.empty() ? "" : ", ", channel.name);
  const std::string u =
      commands.empty() ? "" : fmt::format("//     const {} u[{}_NU] = {{{}}};\n", scalar, name, commands);
  const auto watched = [&](const std::string& line) {
    return m.monitor ? fmt::format(fmt::runtime(line), name) : std::string();
  };
  return fmt::format(
      "// Use\n"
      "//   #include \"{0}.h\"\n"
      "//   static {0}_observer observer;  // {0}_init(&observer) at start\n"
      "{7}"
      "//\n"
      "//   void on_timer(void) {{  // every {1} s\n"
      "//     {8}{4} y[{0}_NY] = {{{2}}};\n"
      "{5}{9}"
      "//     {4} x_hat[{0}_NX];\n"
      "//     const {0}_status status = {0}_step(&observer, y{6});\n"
      "//     if (status != {0}_OK) note_fault(status);  // CLAMPED, HELD: usable for a while\n"
      "//     if (status >= {0}_STALE) {{ enter_safe_mode(); return; }}  // also OUT_OF_RANGE\n"
      "//     if (!{0}_in_domain(&observer)) {{ enter_safe_mode(); return; }}\n"
      "//     {0}_estimate(&observer, x_hat);\n"
      "{10}"
      "//     use(x_hat[{0}_state_{3}]);\n"
      "//   }}\n",
      name, rounded_text(m.sample_period_s), reads, m.states.front().name, scalar, u, u.empty() ? "" : ", u",
      watched("//   static {0}_monitor monitor;    // {0}_monitor_reset(&monitor) at start\n"),
      m.monitor ? "" : "const ", watched("//     {0}_usable_outputs(&monitor, &observer, y, y);\n"),
      watched("//     if ({0}_watch(&monitor, &observer, x_hat) != {0}_NO_ALARM) {{ enter_safe_mode(); return; }}\n"));
}

/// Refuses to compile where double has 32 bits, as on an AVR.
constexpr const char* kDoubleCheck =
    "\n#include <float.h>\n"
    "#if DBL_MANT_DIG != 53\n"
    "#error \"double is not of 64 bits here: export with --scalar float or int16\"\n"
    "#endif\n";

/// Returns the ranges of the measurements and of z, and the start of z.
std::map<std::string, std::string> ranges(const Model& m, const FlownRanges& flown, const Initialiser& init) {
  // Inputs that act apart from the readings have no range.
  const int acting = acting_inputs(m), held = m.nr() + acting;
  const double largest = init.scalar_bytes() == 4 ? static_cast<double>(std::numeric_limits<float>::max())
                                                  : std::numeric_limits<double>::max();
  Eigen::VectorXd wrap = Eigen::VectorXd::Zero(held), least = Eigen::VectorXd::Constant(held, -largest),
                  most = Eigen::VectorXd::Constant(held, largest);
  least.head(m.nr()) = flown.min;
  most.head(m.nr()) = flown.max;
  wrap.head(m.nr()) = flown.wrap;
  std::string relatives;
  int relative = 0;
  for (int j = 0; j < m.nr(); ++j) {
    relative += is_relative(m, j) ? 1 : 0;
    relatives += fmt::format("{}{}", j == 0 ? "" : ", ", is_relative(m, j));
  }
  return {{"INITIAL", init.vector(m.initial_latent, "initial_latent")},
          {"NO_OUTPUT", init.vector(Eigen::VectorXd::Zero(held), "")},
          {"OUTPUT_MIN", init.vector(least, "output_min")},
          {"OUTPUT_MAX", init.vector(most, "output_max")},
          {"WRAP", init.vector(wrap, "wrap")},
          {"ANGLES", flown.any_wraps() ? "true" : ""},
          {"RELATIVE_OUTPUTS", relative > 0 ? "true" : ""},
          {"OTHER_OUTPUTS", relative < m.nr() ? "true" : ""},
          {"RELATIVES", relatives},
          {"RELATIVE", relative > 0 ? "observer->z[r] - resting(observer, r)" : "observer->z[r]"},
          {"LATENT_MIN", init.vector(m.latent_min, "latent_min")},
          {"LATENT_MAX", init.vector(m.latent_max, "latent_max")}};
}

}  // namespace

void check_c99(const Model& m, const std::string& target) {
  if (module_of(m).abilities().c99) return;
  throw Error(fmt::format("\"{}\" is a {} observer; target {} writes {} observers: export it with --target cpp", m.name,
                          structure_name(m), target,
                          names_of_structures([](const StructureModule& s) { return s.abilities().c99; })));
}

PreparedExport for_c99(const PreparedExport& prepared, const std::string& target) {
  check_c99(prepared.model(), target);
  check_weights(prepared.options(), target);
  check_rounding(prepared.model(), prepared.options().scalar);
  return prepared.options().tanh == Activation::kTanh ? prepared : prepared.with(best_tanh(prepared.options()));
}

std::map<std::string, std::string> c99_values(const PreparedExport& prepared, const std::string& name) {
  const Model& m = prepared.model();
  const FoldedModel& folded = prepared.folded();
  const Initialiser& init = prepared.initialiser();
  const QuantisedModel* quantised = prepared.quantised();
  const std::unique_ptr<CppStructure> parts = module_of(m).cpp(prepared.source());
  const std::map<std::string, std::string> own = module_of(m).c99(prepared.source());
  const bool steps_with_tanh = own.contains("TANH") && !own.at("TANH").empty();
  const bool single = init.scalar_bytes() == 4;
  const std::string suffix = single ? "f" : "";

  const std::string map = quantised ? c99_int16_map(name, m, folded, *quantised, init) : c99_map(name, m, folded, init);
  std::map<std::string, std::string> values = {
      {"NAME", name},
      {"SCALAR", init.scalar_name()},
      {"F", suffix},
      {"BITS", single ? "uint32_t" : "uint64_t"},
      {"EXPONENT", single ? "0x7f800000U" : "0x7ff0000000000000U"},
      {"MOST_DOUBLINGS", std::to_string(single ? Halved<float>::kMost : Halved<double>::kMost)},
      {"LARGEST", single ? literal(0x1p100F) : literal(0x1p100)},
      {"TINY", single ? literal(0x1p-100F) : literal(0x1p-100)},
      {"DOUBLE_CHECK", single ? "" : kDoubleCheck},
      {"NX", std::to_string(m.nx())},
      {"NY", std::to_string(m.ny())},
      {"NM", std::to_string(m.measured())},
      {"NZ", std::to_string(m.nz())},
      {"STALE_AFTER", std::to_string(folded.stale_after)},
      {"SAMPLE_PERIOD", init(m.sample_period_s, "sample_period_s")},
      {"NR", std::to_string(m.nr() + acting_inputs(m))},
      {"R", c99_held_size(m)},
      {"FED", c99_readings_size(m)},
      {"OUTPUTS", c99_positions(name + "_output_", measured_channels(m))},
      {"STATES", c99_positions(name + "_state_", m.states)},
      {"STEP_COST", with_activations(parts->step_multiply_adds(), parts->step_activations())},
      {"ESTIMATE_COST", with_activations(parts->estimate_multiply_adds(), parts->estimate_activations())},
      {"ARITHMETIC", c99_arithmetic(folded, quantised, steps_with_tanh, init, suffix)},
      {"NETWORKS", c99_step_networks(folded, quantised, init)},
      {"FUNCTIONS", c99_functions(folded, init)},
      {"TANGENTS", c99_tangents(folded, init, suffix)},
      {"MAP", map},
      {"LINEAR", ""},
      {"SLOPE", ""},
      {"PIECES", "c99/pieces.c.in"},
      {"BETWEEN", "true"},
      {"WARM_START", ""},
      {"WARM_START_BODY", ""},
      {"C99", "true"},  // empty in the single header
      {"COMPLEX", ""},
      {"PHI", "true"},
      {"DIVERGES", ""},
      {"LAST_STATUS", "REJECTED"},
      {"LONGEST_GAP", "1000"},
      {"NOT_A_NUMBER", single ? "0x7fc00000U" : "0x7ff8000000000000U"},
      {"GATE", filled(embedded_text("c99/gate.c.in"),
                      {{"F", suffix}, {"GATES", "true"}, {"IN_SCALAR", quantised && quantised->units ? "" : "true"}})},
      {"DECAYS", m.failures.none() ? "" : "true"},
      {"FOURS", std::string(embedded_text("c99/dense_fours.c.in"))},
      {"INTEGER_FOURS", std::string(embedded_text("c99/int16_fours.c.in"))},
      {"REST", " % 4"},
      {"TOP", ""},
  };
  values.merge(c99_readings(m, name, init));
  values.merge(ranges(m, folded.ranges, init));
  for (const auto& [key, value] : own) values[key] = value;
  for (const char* part : {"PIECES", "SLOPE", "LINEAR", "LATENT", "WARM_START", "WARM_START_BODY", "FILL_MISSING"})
    if (!values[part].empty()) values[part] = filled(embedded_text(values[part]), values);
  add_c99_monitor(m, init, values);
  return values;
}

std::string c99_top(const PreparedExport& prepared, const char* language, const char* target,
                    const std::string& example) {
  const Model& m = prepared.model();
  const ExportOptions& options = prepared.options();
  const std::string& name = prepared.name();
  const std::unique_ptr<CppStructure> parts = module_of(m).cpp(prepared.source());
  std::string flags;
  if (options.scalar != ScalarType::kFloat) flags += fmt::format(" --scalar {}", scalar_name(options.scalar));
  if (name != m.name) flags += " --name " + name;
  const std::size_t bytes = prepared.initialiser().scalar_bytes(),
                    held = static_cast<std::size_t>(m.nr() + acting_inputs(m)),
                    state = bytes * (static_cast<std::size_t>(m.nz()) + held) + 2 * held + 2;
  return wrapped_comment(
             fmt::format("// {0}: {1} in {6}, generated. Do not edit this file. To make it again:\n"
                         "//   nlo export model.json --target {7}{2} -o {0}.h\n"
                         "//\n"
                         "// Estimates {3} from {4}, sampled every {5} s.\n",
                         name, parts->title(), flags, channel_list(m.states, true),
                         channel_list(measured_channels(m), true) +
                             (m.nu() == 0 ? "" : " and the inputs " + channel_list(inputs(m), true)),
                         rounded_text(m.sample_period_s), language, target) +
             parts->description() +
             "// Normalisation and features are folded into the layers.\n"
             "// The bits are the same on every IEEE 754 target, for every compiler and at every optimisation level, "
             "but not "
             "with -ffast-math or clang's -ffp-contract=fast.\n" +
             (prepared.quantised() ? arithmetic_note(prepared) : "") +
             (m.error ? "// The standard deviations of its errors are left out: the C++ header has them.\n" : "") +
             "//\n" + facts(m) + ranges_text(prepared) +
             fmt::format("// An observer takes {} bytes of RAM; the tables are constants. No heap, no library.\n//\n",
                         (state + bytes - 1) / bytes * bytes)) +
         example;
}

std::vector<NamedText> c99(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "c99");
  const std::string& name = prepared.name();
  std::map<std::string, std::string> values = c99_values(prepared, name);
  std::uint32_t hash = 0x811c9dc5U;  // FNV-1a of the values in which both files must agree
  for (const auto& [key, value] : values)
    for (const char c : value) hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193U;
  values["EXPORT"] = fmt::format("0x{:08x}", hash);
  for (const char* part : {"ARITHMETIC", "MAP", "MONITOR", "MONITOR_BODY"}) values[part] = filled(values[part], values);
  values["TYPES"] = filled(embedded_text("c99/types.h.in"), values);
  values["BODY"] = filled(embedded_text("c99/body.c.in"), values);
  values["TOP"] =
      c99_top(prepared, "C99", "c99", example(prepared.model(), name, prepared.initialiser().scalar_name()));
  return {{name + ".h", filled(embedded_text("c99/observer.h.in"), values)},
          {name + ".c", filled(embedded_text("c99/observer.c.in"), values)}};
}

}  // namespace nlo::codegen
