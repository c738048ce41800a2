// SPDX-License-Identifier: MIT
#include "codegen/targets/library.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "codegen/base/embedded_text.h"
#include "codegen/base/xml.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/cpp_header.h"
#include "codegen/targets/export_parts.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

using Values = std::map<std::string, std::string>;

/// Headers of the runtime that a microcontroller does not need: they are included only for vector instructions of x86,
/// 64-bit Arm and RISC-V.
constexpr auto kForVectors = std::to_array<std::string_view>(
    {"nlo/kernels/riscv_vectors.h", "nlo/kernels/x86_dispatch.h", "nlo/kernels/per_isa/aarch64_limited.inc",
     "nlo/kernels/per_isa/avx512_inputs.inc", "nlo/kernels/per_isa/batch.inc", "nlo/kernels/per_isa/one_isa.inc",
     "nlo/kernels/per_isa/panels.inc"});

/// Stops the compiler with one error on processors whose kernels the library leaves out.
constexpr std::string_view kMicrocontrollersOnly =
    "\n#if !defined(NLO_SCALAR_KERNELS) && \\\n"
    "    (defined(__x86_64__) || defined(__SSE2__) || defined(__aarch64__) || defined(__riscv_vector))\n"
    "#error \"this library is for microcontrollers: for this processor, nlo export --target cpp writes the header\"\n"
    "#endif\n";

/// Adds a check that stops an older C++ with one error and its remedy. `processors` is written before the check.
std::string guarded(const std::string& header, const std::string& name, bool has_c99, std::string_view processors) {
  constexpr std::string_view kOnce = "#pragma once\n";
  const std::size_t at = header.find(kOnce) + kOnce.size();
  return header.substr(0, at) + std::string(processors) +
         fmt::format(
             "\n#if __cplusplus < 202002L\n"
             "#error \"{0}.h needs C++20: compile with -std=gnu++20 (README.md says where){1}\"\n"
             "#else\n",
             name, has_c99 ? fmt::format(", or include {}_c99.h, which every compiler accepts", name) : "") +
         header.substr(at) + "\n#endif\n";
}

std::string calls(const char* prefix, const std::vector<Channel>& channels) {
  std::string text;
  for (const Channel& channel : channels)
    text += fmt::format("{}{}{}()", text.empty() ? "" : ", ", prefix, channel.name);
  return text;
}

/// Writes one function per output. `body` gets the number of the output and its range.
template <class Body>
std::string reads(const Model& m, const Initialiser& init, const Body& body) {
  std::string text;
  for (int j = 0; j < m.measured(); ++j)
    text += fmt::format("static {} read_{}() {{ return {}; }}\n", init.scalar_name(),
                        m.outputs[static_cast<std::size_t>(j)].name, body(j, m.output_min(j), m.output_max(j)));
  if (m.nu() == 0) return text;
  text += "// Put the commands of your controller here.\n";
  for (const Channel& input : inputs(m))
    text += fmt::format("static {} command_{}() {{ return 0; }}\n", init.scalar_name(), input.name);
  return text;
}

Values values_of(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  const Initialiser& init = prepared.initialiser();
  const bool single = init.scalar_bytes() == 4, c = module_of(m).abilities().c99, driven = m.nu() > 0;
  std::string upper = name, flags;
  for (char& letter : upper) letter = static_cast<char>(letter >= 'a' && letter <= 'z' ? letter - 'a' + 'A' : letter);
  flags += number_flags(prepared.options());
  if (name != m.name) flags += " --name " + name;
  const std::string input =
      driven ? fmt::format("const nlo::{}::Observer::Input u = {{{{{}}}}};\n", name, calls("command_", inputs(m))) : "";
  return {
      {"NAME", name},
      {"UPPER", upper},
      {"FLAGS", flags},
      {"SCALAR", init.scalar_name()},
      {"MICRO", single ? "1e-6f" : "1e-6"},
      {"STATES", channel_list(m.states, true)},
      {"OUTPUTS", channel_list(measured_channels(m), true)},
      {"PERIOD", fmt::format("{}", m.sample_period_s)},
      {"PERIOD_US", fmt::format("{:.0f}", std::clamp(std::round(m.sample_period_s * 1e6), 1.0, 4e9))},
      {"STEPS_PER_S", fmt::format("{:.0f}", std::clamp(std::round(1.0 / m.sample_period_s), 1.0, 1e9))},
      {"RAM", std::to_string(init.scalar_bytes() *
                             (static_cast<std::size_t>(2 + m.nz() + m.ny() + m.nu()) + m.failures.outputs.size()))},
      {"CPP_CALLS", calls("read_", measured_channels(m))},
      {"CPP_READS", reads(m, init,
                          [&](int j, double min, double max) {
                            return fmt::format("static_cast<{}>(analogRead(A0 + {})) * {} + {}", init.scalar_name(), j,
                                               init((max - min) / 1023.0, "output_max"), init(min, "output_min"));
                          })},
      {"ZEPHYR_READS", reads(m, init,
                             [&](int, double min, double max) {
                               return fmt::format("triangle({}, {})", init(min, "output_min"), init(max, "output_max"));
                             })},
      {"CPP_INPUT", driven ? "  " + input : ""},
      {"ZEPHYR_INPUT", driven ? "    " + input : ""},
      {"CPP_U", driven ? ", u" : ""},
      {"C99_INPUT", driven ? fmt::format("  const {} u[{}_c99_NU] = {{{}}};\n", init.scalar_name(), name,
                                         calls("command_", inputs(m)))
                           : ""},
      {"C99_CMAKE", c ? fmt::format("if(CONFIG_NLO_{1}_C99)\n  zephyr_library_named(nlo_{0})\n"
                                    "  zephyr_library_sources(src/{0}_c99.c)\nendif()\n",
                                    name, upper)
                      : ""},
      {"C99_KCONFIG", c ? fmt::format("\nconfig NLO_{1}_C99\n\tbool \"State observer {0} (C99)\"\n"
                                      "\timply FPU if CPU_HAS_FPU\n\thelp\n\t  The same without C++: <{0}_c99.h>.\n",
                                      name, upper)
                        : ""},
  };
}

/// Returns further values for the package of ros2_control.
Values ros2_values_of(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  const bool sigma = prepared.folded().error.has_value(), monitor = m.monitor.has_value();
  std::string package = name + "_observer", exported, rows;
  for (char& letter : package) letter = static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter);
  const auto states = [&](const char* ending, const char* what) {
    for (const Channel& state : m.states) {
      exported += fmt::format("{}\"{}{}\"", exported.empty() ? "" : ", ", state.name, ending);
      rows += fmt::format("| `{}/{}{}` | {} {} |\n", name, state.name, ending, what, channel_text(state));
    }
  };
  states("", "the estimate of");
  if (sigma) states("_sigma", "the standard deviation of its error:");
  exported += std::string(R"(, "status", "in_domain")") + (monitor ? R"(, "alarm")" : "");
  const auto sensors = [](const std::vector<Channel>& channels) {
    std::string text;
    for (const Channel& channel : channels) text += fmt::format("{}sensor/{}", text.empty() ? "" : ", ", channel.name);
    return text;
  };
  const std::string known = channel_list(inputs(m), true);
  return {{"PACKAGE", package},
          {"XML_STATES", xml_escaped(channel_list(m.states, true))},
          {"XML_OUTPUTS", xml_escaped(channel_list(measured_channels(m), true))},
          {"YAML_OUTPUTS", sensors(measured_channels(m))},
          {"YAML_INPUTS", sensors(inputs(m))},
          {"INPUTS", known},
          {"INPUT_ROW", known.empty() ? "" : fmt::format("| `inputs` | the state interfaces of {} |\n", known)},
          {"STATE_ROWS", rows},
          {"ALARM_ROW", monitor ? fmt::format("| `{}/alarm` | the alarm of the monitor, 0: none |\n", name) : ""},
          {"EXPORTED", exported},
          {"SIGMA", sigma ? "true" : ""},
          {"MONITOR", monitor ? "true" : ""}};
}

/// Fills the templates of `kind`, with the header and the runtime in the folder `headers`. `vectors`: with the
/// kernels for vector instructions.
std::vector<NamedText> library(const PreparedExport& prepared, std::string_view kind, const std::string& headers,
                               std::string_view c99_row, bool vectors = true) {
  check_weights(prepared.options(), kind.substr(0, kind.size() - 1));
  const std::string& name = prepared.name();
  Values values = values_of(prepared);
  const bool c = module_of(prepared.model()).abilities().c99 && !c99_row.empty();
  values.merge(wrapper_values(prepared));
  values.merge(ros2_values_of(prepared));
  values["C99_ROW"] = c ? filled(c99_row, values) : "";
  const std::string header = cpp_header(prepared);

  std::vector<NamedText> files = {
      {headers + name + ".h", guarded(header, name, c, vectors ? "" : kMicrocontrollersOnly)}};
  const std::span<const std::string_view> left_out = vectors ? std::span<const std::string_view>{} : kForVectors;
  for (const std::string& runtime : runtime_headers(header, left_out))
    files.push_back({headers + runtime, std::string(embedded_text(runtime))});
  if (c) {
    ExportOptions renamed = prepared.options();
    renamed.name = name + "_c99";
    for (NamedText& file : c99(prepared.with(renamed)))
      files.push_back({(file.path.ends_with(".h") ? headers : "src/") + file.path, file.text});
  }
  files.push_back({"LICENSE", std::string(embedded_text("LICENSE"))});
  for (NamedText& file : filled_folder(
           kind, name, values, [c](std::string_view text) { return c || text.find("_c99") == std::string_view::npos; }))
    files.push_back(std::move(file));
  return files;
}

}  // namespace

std::vector<std::string> runtime_headers(std::string_view text, std::span<const std::string_view> left_out) {
  std::set<std::string> found;
  const auto follow = [&](const auto& self, std::string_view in) -> void {
    constexpr std::string_view kInclude = "#include ";
    for (std::size_t at = 0; (at = in.find(kInclude, at)) != std::string_view::npos;) {
      at += kInclude.size() + 1;  // behind the quote or bracket
      const std::string name(in.substr(at, in.find_first_of("\">\n", at) - at));
      const bool is_packed = name.starts_with("nlo/") && std::ranges::find(left_out, name) == left_out.end();
      if (is_packed && found.insert(name).second) self(self, embedded_text(name));
    }
  };
  follow(follow, text);
  return {found.begin(), found.end()};
}

std::vector<NamedText> arduino_library(const PreparedExport& prepared) {
  return library(prepared, "arduino/", "src/", "| `<@NAME@_c99.h>` | C99, any core | `examples/@NAME@_c99` |\n", false);
}

std::vector<NamedText> ros2_control_package(const PreparedExport& prepared) {
  return library(prepared, "ros2_control/", "include/", "");
}

std::vector<NamedText> zephyr_module(const PreparedExport& prepared) {
  return library(prepared, "zephyr/", "include/", "| `CONFIG_NLO_@UPPER@_C99=y` | `<@NAME@_c99.h>` | C99 |\n");
}

}  // namespace nlo::codegen
