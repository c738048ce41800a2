// SPDX-License-Identifier: MIT
#include "codegen/targets/fmu.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

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

/// A variable of modelDescription.xml. Value references count from 0 in the order of variables(), as the
/// enumeration of the sources' value references does.
struct Variable {
  std::string name, type, role;  ///< `role`: attributes
  std::string description, unit = {};
  int elements = 1;  ///< more: an array

  bool is_output() const { return role.find("\"output\"") != std::string::npos; }
};

std::vector<Variable> variables(const Model& m) {
  const std::string real = "Float64", local = R"(causality="local" )";
  std::vector<Variable> list = {{"time", real, R"(causality="independent" variability="continuous")", "", "s"}};
  const std::vector<Channel> measured = measured_channels(m);
  for (std::size_t j = 0; j < measured.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    list.push_back({"measured." + measured[j].name, real, R"(causality="input" start="NaN")",
                    fmt::format("measured, from {} to {}; NaN: missing", m.output_min(row), m.output_max(row)),
                    measured[j].unit});
  }
  for (const Channel& input : inputs(m))
    list.push_back({"input." + input.name, real, R"(causality="input" start="0")", "known input", input.unit});
  for (const Channel& state : m.states)
    list.push_back({"estimate." + state.name, real, R"(causality="output")", "estimated", state.unit});
  list.push_back(
      {"status", "Enumeration", R"(causality="output" declaredType="StepStatus")", "what became of the readings"});
  list.push_back({"in_domain", "Boolean", R"(causality="output")", "the latent state is where training has been"});
  if (m.monitor)
    list.push_back({"alarm", "Enumeration", R"(causality="output" declaredType="Alarm")", "what the monitor sees"});
  list.push_back({"z", real, local + R"(variability="continuous")", "latent state", "", m.nz()});
  std::string initial;
  for (const double value : m.initial_latent) initial += fmt::format("{}{}", initial.empty() ? "" : " ", value);
  list.push_back({"initial_z", real, fmt::format(R"(causality="parameter" variability="fixed" start="{}")", initial),
                  "latent state before the first reading", "", m.nz()});
  list.push_back({"sample_period", real, local + fmt::format(R"(variability="constant" start="{}")", m.sample_period_s),
                  "seconds between readings in training", "s"});
  return list;
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, xml_escaped(value));
}

/// The parts of modelDescription.xml and of the page that list variables.
Values lists_of(const std::vector<Variable>& list) {
  Values values;
  std::set<std::string> units;
  for (std::size_t reference = 0; reference < list.size(); ++reference) {
    const Variable& v = list[reference];
    if (!v.unit.empty() && units.insert(v.unit).second)
      values["UNITS"] += fmt::format("    <Unit{}/>\n", attribute("name", v.unit));
    values["VARIABLES"] +=
        fmt::format("    <{} name=\"{}\" valueReference=\"{}\" {}{}{}", v.type, v.name, reference, v.role,
                    attribute("unit", v.unit), attribute("description", v.description)) +
        (v.elements == 1 ? "/>\n" : fmt::format("><Dimension start=\"{}\"/></{}>\n", v.elements, v.type));
    values["ROWS"] += fmt::format("<tr><td>{}</td><td><code>{}{}</code></td><td>{}</td><td>{}</td></tr>\n", reference,
                                  v.name, v.elements == 1 ? "" : fmt::format("[{}]", v.elements), xml_escaped(v.unit),
                                  xml_escaped(v.description));
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

/// All files of an FMU but its library.
std::vector<NamedText> files_of(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "fmu");
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  Values values = wrapper_values(prepared);
  values["MODEL"] = xml_escaped(m.name);
  values["DESCRIPTION"] =
      xml_escaped(fmt::format("State observer: estimates {} from {}.", values.at("STATES"), values.at("OUTPUTS")));
  values.merge(lists_of(variables(m)));
  std::vector<NamedText> files = c99(prepared);
  for (NamedText& file : files) file.path = "sources/" + file.path;
  // Whatever an instance's state or an importer's list of variables rests on makes another token.
  const std::vector<NamedText> described = {{"", values["VARIABLES"]}};
  const std::uint64_t hash = hash_of(described, hash_of(files, 0xcbf29ce484222325U));
  values["HASH"] = fmt::format("0x{:016x}", hash);
  values["TOKEN"] = fmt::format("{{{:016x}{:016x}}}", hash, hash_of(described, hash_of(files, hash)));
  for (NamedText& file : filled_folder("fmu/", name, values)) files.push_back(std::move(file));
  files.push_back({"documentation/licenses/license.txt", std::string(embedded_text("LICENSE"))});
  return files;
}

std::vector<NamedText> archive(const PreparedExport& prepared, const std::vector<NamedText>& files) {
  return {{prepared.name() + ".fmu", zip(files)}};
}

/// "x86_64-linux", as FMI names what an ELF library is for; empty when it is none, or for a processor without a name.
std::string platform_of(std::string_view library) {
  static const std::map<int, std::pair<const char*, const char*>> kMachines = {// of 32 bits, of 64
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
  return processor.empty() ? "" : processor + "-linux";
}

}  // namespace

std::vector<NamedText> fmu_of_sources(const PreparedExport& prepared) {
  return archive(prepared, files_of(prepared));
}

std::vector<NamedText> fmu(const PreparedExport& prepared) {
  constexpr const char* kInstead = "name one in CC, or export --target fmu-sources, which the importer compiles";
  constexpr auto kPatience = std::chrono::seconds(300);
  const TemporaryFolder folder((std::filesystem::temp_directory_path() / "nlo-fmu").string());
  const std::string library = prepared.name() + ".so";
  const char* chosen = std::getenv("CC");
  std::vector<std::string> command = words_of(chosen != nullptr ? chosen : "");
  if (command.empty()) command = {"cc"};
  command.insert(command.end(), {"-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-s", "-o", library});
  std::vector<NamedText> files = files_of(prepared), sources;
  for (const NamedText& file : files) {
    const std::filesystem::path path(file.path);
    if (path.extension() == ".c") command.push_back(path.filename().string());
    if (path.parent_path() == "sources") write_file_atomically((folder.name() / path.filename()).string(), file.text);
  }
  const std::string failure = run_child(command, folder.name(), kPatience);
  if (!failure.empty()) throw Error(fmt::format("no binary for the FMU: {}; {}", failure, kInstead));
  const std::string binary = read_file(folder.name() + "/" + library), platform = platform_of(binary);
  if (platform.empty())
    throw Error(fmt::format("no binary for the FMU: {} writes no library for Linux on a processor that FMI names; {}",
                            command.front(), kInstead));
  files.push_back({"binaries/" + platform + "/" + library, binary});
  return archive(prepared, files);
}

}  // namespace nlo::codegen
