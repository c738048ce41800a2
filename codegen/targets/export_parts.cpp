// SPDX-License-Identifier: MIT
#include "codegen/targets/export_parts.h"

#include <fmt/format.h>

#include <limits>

#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/number.h"
#include "codegen/targets/error_limits.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

std::string channel_text(const Channel& channel) {
  return channel.name + (channel.unit.empty() ? "" : " [" + safe_comment(channel.unit, 20) + "]");
}

std::string channel_list(const std::vector<Channel>& channels, bool with_units) {
  std::string text;
  for (const Channel& channel : channels) {
    if (!text.empty()) text += ", ";
    text += with_units ? channel_text(channel) : channel.name;
  }
  return text;
}

std::string with_activations(Eigen::Index multiply_adds, Eigen::Index activations) {
  return grouped(multiply_adds) + " multiply-adds" +
         (activations == 0 ? "" : ", " + grouped(activations) + " activations");
}

std::string facts(const Model& m) {
  constexpr std::size_t kLongestName = 28, kLongestFact = 84;
  std::string text;
  for (const auto& [name, fact] : m.provenance) {
    // A fact of several lines is the whole experiment, which only the model file contains.
    if (fact.find_first_of("\r\n") != std::string::npos) continue;
    text += fmt::format("//   {:<{}}  {}\n", safe_comment(name, kLongestName), kLongestName,
                        safe_comment(fact, kLongestFact));
  }
  return text.empty() ? "" : "// About the model\n" + text + "//\n";
}

std::string ranges_text(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const FlownRanges& ranges = prepared.folded().ranges;
  const std::vector<Channel> channels = readings(m);
  std::string text = "// Readings\n";
  bool wraps = false, clamps = false;
  for (int j = 0; j < m.ny() + static_cast<int>(m.inputs.size()); ++j) {
    const Channel& channel = channels[static_cast<std::size_t>(j)];
    if (j >= m.measured() && j < m.ny()) continue;  // computed
    std::string said;
    if (ranges.wrap(j) > 0.0) {
      said = fmt::format("whole multiples of {:.9g} are removed; held outside of {:.9g} to {:.9g}", ranges.wrap(j),
                         ranges.min(j), ranges.max(j));
      wraps = true;
    } else {
      said = fmt::format("used unchanged from {:.6g} to {:.6g}, clamped beyond", ranges.min(j), ranges.max(j));
      clamps = true;
    }
    text += fmt::format("//   {:<26}  {}\n", channel_text(channel), said);
  }
  if (m.inputs.empty())
    for (const Channel& channel : inputs(m))
      text += fmt::format("//   {:<26}  used unchanged\n", channel_text(channel));
  if (wraps)
    text += "// If a reading may go beyond, give it without its whole multiples (fmod): then it has no limit.\n";
  if (clamps)
    text += fmt::format(
        "// While a reading is clamped, in_domain() is false.\n"
        "// After {} such samples in a row the status is out of range.\n",
        prepared.folded().stale_after);
  return text + "//\n";
}

std::string arithmetic_note(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const ExportOptions& options = prepared.options();
  const bool is_int16 = options.scalar == ScalarType::kInt16, half = options.weights != WeightType::kFull;
  const std::string tanh = tanh_note(options);
  if (!is_int16 && !half && tanh.empty()) return "";
  const ExportError& error = prepared.error();
  const bool has_table =
      is_int16 && (prepared.quantised()->units || (prepared.quantised()->map.activation != Activation::kRelu &&
                                                   prepared.quantised()->map.layers.size() > 1));
  std::string text = "//\n";
  if (is_int16)
    text += fmt::format(
        "// {} in int16: weights of 16 bits, sums of 32 bits that cannot overflow{}. All else is float.\n"
        "// If z leaves the domain, T* returns its value at the nearest point of the domain.\n",
        prepared.quantised()->units ? "Gated units and T* are" : "T* is", has_table ? ", tanh by a table" : "");
  if (half)
    text += fmt::format("// Weights of layers are in {}, 2 bytes each; the arithmetic and all else is float.\n",
                        weight_name(options.weights));
  if (!tanh.empty()) text += fmt::format("// {}.\n", tanh);
  text += fmt::format(
      "// Error of this arithmetic over {}:\n"
      "// the largest, the 99.9 % quantile and the rms in the domain; the largest outside of it:\n",
      samples_text(error));
  for (int i = 0; i < m.nx(); ++i)
    text += fmt::format("//   {:<26}  {:.1e}, {:.1e}, {:.1e}; {}\n",
                        channel_text(m.states[static_cast<std::size_t>(i)]), error.max(i), error.quantile999(i),
                        error.rms(i), error.outside == 0 ? "-" : fmt::format("{:.1e}", error.max_outside(i)));
  return text;
}

std::vector<NamedText> filled_folder(std::string_view folder, const std::string& name,
                                     const std::map<std::string, std::string>& values,
                                     const std::function<bool(std::string_view)>& wanted) {
  constexpr std::string_view kEnding = ".in";
  std::vector<NamedText> files;
  for (const EmbeddedText& text : embedded_texts()) {
    if (!text.name.starts_with(folder) || !wanted(text.name)) continue;
    std::string path(text.name.substr(folder.size(), text.name.size() - folder.size() - kEnding.size()));
    for (std::size_t at = 0; (at = path.find("NAME", at)) != std::string::npos; at += name.size())
      path.replace(at, 4, name);
    files.push_back({path, filled(text.text, values)});
  }
  return files;
}

std::map<std::string, std::string> wrapper_values(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const bool single = prepared.initialiser().scalar_bytes() == 4;
  return {
      {"NAME", prepared.name()},
      {"FLAGS", number_flags(prepared.options()) + (prepared.name() == m.name ? "" : " --name " + prepared.name())},
      {"SCALAR", prepared.initialiser().scalar_name()},
      {"LARGEST",
       literal(single ? static_cast<double>(std::numeric_limits<float>::max()) : std::numeric_limits<double>::max())},
      {"PERIOD", literal(m.sample_period_s)},
      {"STATES", channel_list(m.states, true)},
      {"OUTPUTS", channel_list(measured_channels(m), true)},
      {"INPUT_PORT", ""},
      {"INPUT_ROW", ""},
      {"NX", std::to_string(m.nx())},
      {"NM", std::to_string(m.measured())},
      {"NU", std::to_string(m.nu())},
      {"NZ", std::to_string(m.nz())},
      {"MONITORED", m.monitor ? "true" : ""},
      {"DRIVEN", m.nu() > 0 ? "true" : ""},
      {"U", m.nu() > 0 ? ", u" : ""},
  };
}

void check_rounding(const Model& m, ScalarType scalar) {
  if (scalar == ScalarType::kDouble) return;
  const auto rounded = [](double value) { return static_cast<float>(value); };
  if (!(rounded(m.sample_period_s) > 0.0F))
    throw Error("sample_period_s rounds to zero in float; export with scalar double");
  const auto check = [&](const char* field, const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
    for (Eigen::Index j = 0; j < low.size(); ++j)
      if (!(rounded(low(j)) < rounded(high(j))))
        throw Error(
            fmt::format("{0}_min[{1}] and {0}_max[{1}] are equal in float; export with scalar double", field, j));
  };
  check("output", m.output_min, m.output_max);
  check("input", m.input_min, m.input_max);
}

}  // namespace nlo::codegen
