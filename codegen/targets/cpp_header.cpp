// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_header.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "codegen/base/number.h"
#include "codegen/fold/fold.h"
#include "codegen/model/activations.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/cpp_cost.h"
#include "codegen/targets/export_parts.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/cpp_monitor.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

/// All that the parts of the header are made from.
struct Source {
  const PreparedExport& prepared;
  const Model& model;
  const FoldedModel& folded;
  const CppStructure& structure;
  const Initialiser& init;
  const ExportOptions& options;
  const std::string& name;
};

/// Cost of estimate_with_error() beside estimate(): the squares of the hidden layer, its sums, and a 2^v for each
/// state.
std::string error_cost(const Source& s) {
  if (!s.folded.error) return s.model.error ? "//   its standard deviations are not in int16 and left out\n" : "";
  const DenseLayer& layer = s.folded.error->layer;
  constexpr Eigen::Index kPowerOf2 = 10;
  return fmt::format("//   estimate_with_error()  {} multiply-adds more\n",
                     grouped(layer.weights.cols() / 2 + layer.weights.size() + kPowerOf2 * layer.bias.size()));
}

std::string costs(const Source& s) {
  const CppCost cost = cpp_cost(s.model, s.structure, s.init);
  return fmt::format(
      "// Cost\n"
      "//   step()      {}\n"
      "//   estimate()  {}\n"
      "{}"
      "//   kModel      {} bytes of constants{}\n"
      "//   Observer    {} bytes of RAM where pointers have 32 bits\n",
      with_activations(cost.step_multiply_adds, cost.step_activations),
      with_activations(cost.estimate_multiply_adds, cost.estimate_activations), error_cost(s),
      grouped(cost.constant_bytes),
      s.options.scalar == ScalarType::kInt16 ? "" : " (more where layers are padded to cache lines for SIMD)",
      grouped(cost.observer_bytes));
}

/// `read_alpha()`, or `{{read_alpha(), read_load()}}`.
std::string argument(const std::vector<Channel>& channels, bool is_scalar) {
  std::string reads;
  for (const Channel& channel : channels) reads += fmt::format("{}read_{}()", reads.empty() ? "" : ", ", channel.name);
  return is_scalar ? reads : "{{" + reads + "}}";
}

/// The lines of the example that read the estimate, and judge it where there is a monitor.
std::string estimate_lines(bool watched, bool has_error) {
  const std::string estimate = has_error ? "observer.estimate_with_error()" : "observer.estimate()";
  if (watched && has_error)
    return "//     const auto estimate = " + estimate +
           ";\n"
           "//     if (monitor.watch(observer, estimate.x_hat) != nlo::Alarm::kNone) return enter_safe_mode();\n"
           "//     const auto [x_hat, sigma, bound_95] = monitor.widened(estimate);\n";
  return std::string("//     const auto ") + (has_error ? "[x_hat, sigma, bound_95]" : "x_hat") + " = " + estimate +
         ";\n" +
         (watched ? "//     if (monitor.watch(observer, x_hat) != nlo::Alarm::kNone) return enter_safe_mode();\n" : "");
}

std::string example(const Source& s) {
  const bool scalars = s.model.measured() == 1 && s.model.nu() <= 1, watched = s.model.monitor.has_value();
  std::string arguments = argument(measured_channels(s.model), scalars);
  if (watched) arguments = fmt::format("monitor.usable_outputs({}, observer)", arguments);
  if (s.model.nu() > 0) arguments += ", " + argument(inputs(s.model), scalars);
  return fmt::format(
      "// Use\n"
      "//   #include \"{0}.h\"\n"
      "//   constinit static nlo::{0}::Observer observer{{nlo::{0}::kModel}};\n"
      "{4}"
      "//\n"
      "//   void on_timer() {{  // every {1} s\n"
      "//     const auto status = observer.step({2});\n"
      "//     if (status != nlo::StepStatus::kOk) note_fault(status);  // kClamped, kHeld: usable for a while\n"
      "//     if (status >= nlo::StepStatus::kStale) return enter_safe_mode();  // also kOutOfRange\n"
      "//     if (!observer.in_domain()) return enter_safe_mode();\n"
      "{5}"
      "//     use(x_hat[nlo::{0}::State::{3}]);\n"
      "//   }}\n",
      s.name, rounded_text(s.model.sample_period_s), arguments, s.model.states.front().name,
      watched ? fmt::format("//   constinit static nlo::{0}::Monitor monitor{{nlo::{0}::kMonitor}};\n", s.name) : "",
      estimate_lines(watched, s.folded.error.has_value()));
}

std::string top_comment(const Source& s) {
  std::string options = number_flags(s.options);
  if (s.name != s.model.name) options += " --name " + s.name;
  const std::string driven = s.model.nu() > 0 ? " and the inputs " + channel_list(inputs(s.model), true) : "";
  return wrapped_comment(fmt::format("// {0}: {6}, generated. Do not edit; make it again by\n"
                                     "//   nlo export model.json{1} -o {0}.h\n"
                                     "//\n"
                                     "// Estimates {2} from {3}{4}, sampled every {5} s.\n",
                                     s.name, options, channel_list(s.model.states, true),
                                     channel_list(measured_channels(s.model), true), driven,
                                     rounded_text(s.model.sample_period_s), s.structure.title()) +
                         s.structure.description() + "// Normalisation and features are folded into the layers.\n" +
                         arithmetic_note(s.prepared) + "//\n" + facts(s.model) + ranges_text(s.prepared) + costs(s) +
                         "//\n") +
         example(s);
}

std::string enumeration(const char* name, const std::vector<Channel>& channels) {
  return fmt::format("struct {} {{\n  enum : int {{ {} }};\n}};\n", name, channel_list(channels, false));
}

/// Text on the outputs that step() computes.
std::string computed(const Source& s) {
  const int count = s.model.ny() - s.model.measured();
  if (count == 0) return "";
  const std::string scalar = s.init.scalar_name();
  return fmt::format(
             "/// Outputs that are computed: readings behind those that are measured.\n"
             "struct Computed {{\n  static constexpr int kCount = {};\n  static constexpr void fill({} (&r)[{}]) {{\n",
             count, scalar, s.model.nr()) +
         computed_statements(
             s.model, s.init, "    ",
             [&](const std::string& product) { return fmt::format("rounded<{}>({})", scalar, product); }) +
         "  }\n};\n";
}

/// Model and Observer. A model with slow outputs is a type of its own, with their periods.
std::string types(const Source& s) {
  const CppStructure& structure = s.structure;
  const std::string observer = fmt::format("using Observer = {}<Model>;\n", structure.observer());
  if (!has_slow_outputs(s.model))
    return structure.declarations() + "using Model = " + structure.model_type() + observer;
  return structure.declarations() + "using EverySample = " + structure.model_type() +
         fmt::format(
             "struct Model : EverySample {{\n  static constexpr std::uint16_t kNotDue[kNr] = {{{}}};  // samples for "
             "which a reading is not due\n}};\n",
             fmt::join(not_due(s.model), ", ")) +
         observer;
}

std::string model_constant(const Source& s) {
  const Model& m = s.model;
  const bool derived = has_slow_outputs(m);
  const FlownRanges& ranges = s.folded.ranges;
  const std::string reason = module_of(m).fastest_mode(m) ? ": the fastest mode's time constant" : "";
  std::string text = derived ? "inline constexpr Model kModel = {{\n" : "inline constexpr Model kModel = {\n";
  text += fmt::format("    .sample_period_s = {},\n", s.init(m.sample_period_s, "sample_period_s"));
  text += fmt::format("    .stale_after = {},  // held measurements{}\n", s.folded.stale_after, reason);
  text += s.structure.leading_fields();
  text += fmt::format("    .outputs = {{.min = {}, .max = {}, .wrap = {}}},\n", s.init.vector(ranges.min, "output_min"),
                      s.init.vector(ranges.max, "output_max"), s.init.vector(ranges.wrap, "wrap"));
  text += fmt::format("    .domain = {{.latent_min = {},\n", s.init.vector(m.latent_min, "latent_min"));
  text += fmt::format("               .latent_max = {}}},\n", s.init.vector(m.latent_max, "latent_max"));
  text += s.structure.trailing_fields();
  if (!m.failures.none()) {
    const SensorFailures& f = m.failures;
    text += fmt::format("    .failures = {{.output = {{{}}}, .rest = {}, .rate = {}, .keep = {}}},\n",
                        fmt::join(f.outputs.begin(), f.outputs.end(), ", "), s.init.vector(f.rest, "may_fail.rest"),
                        s.init(1.0 / f.staleness_s, "may_fail.staleness_s"),
                        s.init(std::exp(-m.sample_period_s / f.staleness_s), "may_fail.staleness_s"));
  }
  return text + (derived ? "}};\n" : "};\n");
}

}  // namespace

std::string cpp_header(const PreparedExport& prepared) {
  const Model& model = prepared.model();
  const Initialiser& init = prepared.initialiser();
  const bool quantised = prepared.quantised() != nullptr;
  check_rounding(model, prepared.options().scalar);
  const auto structure = module_of(model).cpp(prepared.source());
  const Source s{prepared, model, prepared.folded(), *structure, init, prepared.options(), prepared.name()};

  std::string text = top_comment(s);
  text += fmt::format("#pragma once\n\n#include <nlo/{}>\n", structure->header());
  const auto include = [&text](bool uses, const char* header) {
    if (uses) text += fmt::format("#include <nlo/{}>\n", header);
  };
  include(model.error && !quantised, "error_head.h");
  include(prepared.options().weights != WeightType::kFull, "kernels/weight.h");
  include(model.monitor.has_value(), "monitor.h");
  include(quantised, "quantised_map.h");
  include(quantised && prepared.quantised()->units, "quantised_units.h");
  include(model.saturates(), "saturation.h");
  include(!model.failures.none(), "sensor_failures.h");
  text += "\n";
  text += fmt::format("namespace nlo::{} {{\n\n", s.name);
  text += fmt::format("/// Positions in a measurement{} and in an estimate.\n", model.nu() > 0 ? ", in an input" : "");
  text += enumeration("Output", measured_channels(model));
  if (model.nu() > 0) text += enumeration("Input", inputs(model));
  text += enumeration("State", model.states) + "\n";
  text += "namespace weights {\n";
  if (quantised)
    text +=
        fmt::format("\n// QuantisedDense<inputs, neurons, shift> reads integers up to +-32767; sum / 2^shift is {}.\n",
                    activation_row(prepared.quantised()->map.activation).int16_form);
  for (const CppNetwork& network : structure->networks()) text += network.layers(init);
  text += "\n}  // namespace weights\n\n";
  for (const CppNetwork& network : structure->networks()) text += network.using_declaration();
  text += computed(s) + types(s) + "\n" + model_constant(s);
  if (model.monitor) text += cpp_monitor(model, init);
  text += fmt::format("\n}}  // namespace nlo::{}\n", s.name);
  return text;
}

}  // namespace nlo::codegen
