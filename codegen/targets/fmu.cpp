// SPDX-License-Identifier: MIT
#include "codegen/targets/fmu.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <utility>

#include "codegen/base/child.h"
#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/temporary.h"
#include "codegen/base/xml.h"
#include "codegen/base/zip.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/export_parts.h"

namespace nlo::codegen {
namespace {

using Values = std::map<std::string, std::string>;

enum class Fmi { k2, k3 };

struct EnumerationItem {
  const char* name;
  int value;
  const char* description;
};
constexpr auto kStatusItems = std::to_array<EnumerationItem>(
    {{"ok", 0, "all readings were used unchanged"},
     {"clamped", 1, "a reading outside of its range was clamped to it"},
     {"held", 2, "a reading was missing, or an angle out of range: its last good value was used"},
     {"stale", 3, "a reading was held for about a time constant: do not trust the estimates"},
     {"out_of_range", 4, "a reading was out of range for about a time constant: do not trust the estimates"},
     {"rejected", 5, "the step was too long: it changed nothing"},
     {"reset", 7, "a bit flip corrupted the state: the observer starts with the next readings"}});
constexpr auto kAlarmItems = std::to_array<EnumerationItem>(
    {{"none", 0, ""},
     {"innovation_mean", 1, "the errors of the predictions have a mean that noise does not explain"},
     {"innovation_variance", 2, "the errors of the predictions are larger than in training"},
     {"innovation_correlation", 3, "neighbouring errors of the predictions are correlated"},
     {"latent_distance", 4, "the latent state is in a region that training seldom reached"},
     {"missing", 5, "too many readings are missing, frozen or rejected by the gate"},
     {"disagreement", 6, "the map and its linear fit disagree: the estimate extrapolates"},
     {"reset", 7, "a bit flip corrupted memory: the monitor starts again"}});

/// A variable of modelDescription.xml. Value references count from 0 in the order of variables(), like the enumeration
/// in the sources. If the version of FMI has no arrays, the elements of arrays follow.
struct Variable {
  std::string name, type, causality, variability = {};  ///< `type`: as FMI 3.0 names it
  std::string start = {}, declared_type = {};
  std::string description = {}, unit = {};
  int elements = 1;  ///< number of elements; above 1: an array

  bool is_output() const { return causality == "output"; }
};

std::vector<Variable> variables(const Model& m) {
  const std::string real = "Float64";
  std::vector<Variable> list = {
      {.name = "time", .type = real, .causality = "independent", .variability = "continuous", .unit = "s"}};
  const std::vector<Channel> measured = measured_channels(m);
  for (std::size_t j = 0; j < measured.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    list.push_back(
        {.name = "measured." + measured[j].name,
         .type = real,
         .causality = "input",
         .start = "NaN",
         .description = fmt::format("measured, from {} to {}; NaN: missing", m.output_min(row), m.output_max(row)),
         .unit = measured[j].unit});
  }
  for (const Channel& input : inputs(m))
    list.push_back({.name = "input." + input.name,
                    .type = real,
                    .causality = "input",
                    .start = "0",
                    .description = "known input",
                    .unit = input.unit});
  for (const Channel& state : m.states)
    list.push_back({.name = "estimate." + state.name,
                    .type = real,
                    .causality = "output",
                    .description = "estimated",
                    .unit = state.unit});
  list.push_back({.name = "status",
                  .type = "Enumeration",
                  .causality = "output",
                  .declared_type = "StepStatus",
                  .description = "result of the step: how the readings were used"});
  list.push_back({.name = "in_domain",
                  .type = "Boolean",
                  .causality = "output",
                  .description = "true if the latent state is in the range of the training"});
  if (m.monitor)
    list.push_back({.name = "alarm",
                    .type = "Enumeration",
                    .causality = "output",
                    .declared_type = "Alarm",
                    .description = "alarm of the monitor"});
  list.push_back({.name = "z",
                  .type = real,
                  .causality = "local",
                  .variability = "continuous",
                  .description = "latent state",
                  .elements = m.nz()});
  std::string initial;
  for (const double value : m.initial_latent) initial += fmt::format("{}{}", initial.empty() ? "" : " ", value);
  list.push_back({.name = "initial_z",
                  .type = real,
                  .causality = "parameter",
                  .variability = "fixed",
                  .start = initial,
                  .description = "latent state before the first reading",
                  .elements = m.nz()});
  list.push_back({.name = "sample_period",
                  .type = real,
                  .causality = "local",
                  .variability = "constant",
                  .start = fmt::format("{}", m.sample_period_s),
                  .description = "sample period of the training",
                  .unit = "s"});
  return list;
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, xml_escaped(value));
}

std::string enumeration_items(std::span<const EnumerationItem> items) {
  std::string text;
  for (const EnumerationItem& item : items)
    text += fmt::format("      <Item name=\"{}\" value=\"{}\"{}/>\n", item.name, item.value,
                        attribute("description", item.description));
  return text;
}

/// Writes a variable of FMI 3.0.
std::string variable_text(const Variable& v, std::size_t reference) {
  return fmt::format("    <{} name=\"{}\" valueReference=\"{}\"{}{}{}{}{}{}", v.type, v.name, reference,
                     attribute("causality", v.causality), attribute("variability", v.variability),
                     attribute("start", v.start), attribute("declaredType", v.declared_type), attribute("unit", v.unit),
                     attribute("description", v.description)) +
         (v.elements == 1 ? "/>\n" : fmt::format("><Dimension start=\"{}\"/></{}>\n", v.elements, v.type));
}

/// Writes a scalar variable of FMI 2.0.
std::string scalar_variable_text(const Variable& v, std::size_t reference) {
  const bool is_real = v.type == "Float64";
  return fmt::format("    <ScalarVariable name=\"{}\" valueReference=\"{}\"{}{}{}><{}{}{}{}/></ScalarVariable>\n",
                     v.name, reference, attribute("description", v.description), attribute("causality", v.causality),
                     attribute("variability", is_real ? v.variability : "discrete"), is_real ? "Real" : v.type,
                     attribute("declaredType", v.declared_type), attribute("unit", v.unit),
                     attribute("start", v.start));
}

/// Returns the variables of FMI 2.0 with their references: the scalars, then the elements of the arrays, z[1] and so
/// on. Time is not a variable there.
std::vector<std::pair<Variable, std::size_t>> scalars_of(const std::vector<Variable>& list) {
  std::vector<std::pair<Variable, std::size_t>> scalars;
  for (std::size_t reference = 0; reference < list.size(); ++reference)
    if (list[reference].elements == 1 && list[reference].causality != "independent")
      scalars.emplace_back(list[reference], reference);
  std::size_t next = list.size();
  for (const Variable& array : list) {
    if (array.elements == 1) continue;
    std::istringstream starts(array.start);
    for (int k = 1; k <= array.elements; ++k) {
      Variable element = array;
      element.name = fmt::format("{}[{}]", array.name, k);
      element.elements = 1;
      element.start.clear();
      starts >> element.start;
      scalars.emplace_back(element, next++);
    }
  }
  return scalars;
}

/// Returns the parts of modelDescription.xml and of the page that list variables.
Values lists_of(const std::vector<Variable>& list, Fmi version) {
  Values values = {{"STATUS_ITEMS", enumeration_items(kStatusItems)}, {"ALARM_ITEMS", enumeration_items(kAlarmItems)}};
  std::set<std::string> units;
  const auto add_row = [&](const Variable& v, std::size_t reference) {
    if (!v.unit.empty() && units.insert(v.unit).second)
      values["UNITS"] += fmt::format("    <Unit{}/>\n", attribute("name", v.unit));
    values["ROWS"] += fmt::format("<tr><td>{}</td><td><code>{}{}</code></td><td>{}</td><td>{}</td></tr>\n", reference,
                                  v.name, v.elements == 1 ? "" : fmt::format("[{}]", v.elements), xml_escaped(v.unit),
                                  xml_escaped(v.description));
  };
  if (version == Fmi::k2) {
    std::size_t index = 0;  // in the list, from 1
    for (const auto& [variable, reference] : scalars_of(list)) {
      ++index;
      add_row(variable, reference);
      values["VARIABLES"] += scalar_variable_text(variable, reference);
      if (variable.is_output()) values["UNKNOWNS"] += fmt::format("      <Unknown index=\"{}\"/>\n", index);
    }
    return values;
  }
  for (std::size_t reference = 0; reference < list.size(); ++reference) {
    const Variable& v = list[reference];
    add_row(v, reference);
    values["VARIABLES"] += variable_text(v, reference);
    if (!v.is_output()) continue;
    values["STRUCTURE"] += fmt::format("    <Output valueReference=\"{}\"/>\n", reference);
    values["UNKNOWNS"] += fmt::format("    <InitialUnknown valueReference=\"{}\"/>\n", reference);
  }
  return values;
}

std::uint64_t hash_of(const std::vector<NamedText>& files, std::uint64_t hash) {  // FNV-1a
  for (const NamedText& file : files)
    for (const char c : file.text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

/// Returns all files of an FMU except its library. The functions of FMI 2.0 call those of FMI 3.0, which are included
/// under other names.
std::vector<NamedText> files_of(const PreparedExport& given, Fmi version) {
  const bool is_2 = version == Fmi::k2;
  const PreparedExport prepared = for_c99(given, is_2 ? "fmu2" : "fmu");
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  Values values = wrapper_values(prepared);
  values["MODEL"] = xml_escaped(m.name);
  values["DESCRIPTION"] =
      xml_escaped(fmt::format("State observer: estimates {} from {}.", values.at("STATES"), values.at("OUTPUTS")));
  values["FMI2"] = is_2 ? "true" : "";
  values["FMI3"] = is_2 ? "" : "true";
  values["FMI"] = is_2 ? "2.0" : "3.0";
  values["DO_STEP"] = is_2 ? "fmi2DoStep" : "fmi3DoStep";
  values["LISTED_IN"] = is_2 ? "modelDescription.xml" : "sources/buildDescription.xml";
  values.merge(lists_of(variables(m), version));
  std::vector<NamedText> files = c99(prepared);
  for (NamedText& file : files) file.path = "sources/" + file.path;
  // The token changes with everything that an instance's state or an importer's list of variables depends on.
  const std::vector<NamedText> described = {{"", values["VARIABLES"]}};
  const std::uint64_t hash = hash_of(described, hash_of(files, 0xcbf29ce484222325U));
  values["HASH"] = fmt::format("0x{:016x}", hash);
  values["TOKEN"] = fmt::format("{{{:016x}{:016x}}}", hash, hash_of(described, hash_of(files, hash)));
  const auto is_wanted = [is_2](std::string_view path) {
    return !is_2 || (path.find(".xml") == std::string_view::npos && path.find("_refused") == std::string_view::npos);
  };
  for (NamedText& file : filled_folder("fmu/", name, values, is_wanted)) files.push_back(std::move(file));
  if (is_2)
    for (NamedText& file : filled_folder("fmu2/", name, values)) files.push_back(std::move(file));
  files.push_back({"documentation/licenses/license.txt", std::string(embedded_text("LICENSE"))});
  return files;
}

std::vector<NamedText> archive(const PreparedExport& prepared, const std::vector<NamedText>& files) {
  return {{prepared.name() + ".fmu", zip(files)}};
}

/// Returns the platform of an ELF library as FMI names it: "x86_64-linux" by FMI 3.0, "linux64" by FMI 2.0. Empty if it
/// is no ELF library or FMI has no name for its processor.
std::string platform_of(std::string_view library, Fmi version) {
  static const std::map<int, std::pair<const char*, const char*>> kMachines = {// for 32 bits, for 64
                                                                               {3, {"x86", ""}},
                                                                               {40, {"aarch32", ""}},
                                                                               {62, {"", "x86_64"}},
                                                                               {183, {"", "aarch64"}},
                                                                               {243, {"riscv32", "riscv64"}}};
  constexpr std::size_t kClass = 4, kMachine = 18, kHeader = 20;
  if (library.size() < kHeader || !library.starts_with("\x7f"
                                                       "ELF"))
    return "";
  const auto machine = kMachines.find(static_cast<unsigned char>(library[kMachine]));
  if (machine == kMachines.end()) return "";
  const std::string processor = library[kClass] == 1 ? machine->second.first : machine->second.second;
  if (version == Fmi::k2 && processor == "x86_64") return "linux64";
  if (version == Fmi::k2 && processor == "x86") return "linux32";
  return processor.empty() ? "" : processor + "-linux";
}

/// Returns the archive with a library that the compiler of this machine has made.
std::vector<NamedText> with_library(const PreparedExport& prepared, Fmi version) {
  const std::string instead = fmt::format("name one in CC, or export --target {}-sources, which the importer compiles",
                                          version == Fmi::k2 ? "fmu2" : "fmu");
  constexpr auto kPatience = std::chrono::seconds(300);
  const TemporaryFolder folder((std::filesystem::temp_directory_path() / "nlo-fmu").string());
  const std::string library = prepared.name() + ".so";
  const char* chosen = std::getenv("CC");
  std::vector<std::string> command = words_of(chosen != nullptr ? chosen : "");
  if (command.empty()) command = {"cc"};
  command.insert(command.end(), {"-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-s", "-o", library});
  std::vector<NamedText> files = files_of(prepared, version), sources;
  for (const NamedText& file : files) {
    const std::filesystem::path path(file.path);
    if (path.extension() == ".c") command.push_back(path.filename().string());
    if (path.parent_path() == "sources") write_file_atomically((folder.name() / path.filename()).string(), file.text);
  }
  const std::string failure = run_child(command, folder.name(), kPatience);
  if (!failure.empty()) throw Error(fmt::format("no binary for the FMU: {}; {}", failure, instead));
  const std::string binary = read_file(folder.name() + "/" + library), platform = platform_of(binary, version);
  if (platform.empty())
    throw Error(fmt::format("no binary for the FMU: {} writes no library for Linux on a processor that FMI names; {}",
                            command.front(), instead));
  files.push_back({"binaries/" + platform + "/" + library, binary});
  return archive(prepared, files);
}

}  // namespace

std::vector<NamedText> fmu_of_sources(const PreparedExport& prepared) {
  return archive(prepared, files_of(prepared, Fmi::k3));
}

std::vector<NamedText> fmu(const PreparedExport& prepared) {
  return with_library(prepared, Fmi::k3);
}

std::vector<NamedText> fmu2_of_sources(const PreparedExport& prepared) {
  return archive(prepared, files_of(prepared, Fmi::k2));
}

std::vector<NamedText> fmu2(const PreparedExport& prepared) {
  return with_library(prepared, Fmi::k2);
}

}  // namespace nlo::codegen
