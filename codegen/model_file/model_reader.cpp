// SPDX-License-Identifier: MIT
// parse_model() turns JSON into a validated model. Every field is required, except those that has() checks. Unknown
// fields are errors. Each field has one type.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/json_field.h"
#include "codegen/base/vlq.h"
#include "codegen/model/model_fields.h"
#include "codegen/model_file/model_file.h"
#include "codegen/model_file/model_upgrade.h"
#include "codegen/model_file/monitor_fields.h"
#include "codegen/model_file/validate.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

constexpr int kDeepest = 8;  // a model nests 7 levels: { drive { forward_map { layers [ { weights [ [

/// Reads one text for each of `channels`; all have the same length.
Eigen::MatrixXi counts(const Field& field, Eigen::Index channels) {
  if (static_cast<Eigen::Index>(field.array_size()) != channels)
    field.fail(fmt::format("has {} texts; it must have one for each of {} channels", field.array_size(), channels));
  Eigen::MatrixXi all;
  for (Eigen::Index j = 0; j < channels; ++j) {
    const Field one = field[static_cast<std::size_t>(j)];
    const auto row = from_vlq(text(one), kMostFlightCount);
    if (!row) one.fail("is not Base64 VLQ of numbers within 2^24; use the unchanged file that nlo train wrote");
    if (j == 0) all.resize(channels, row->size());
    if (row->size() != all.cols())
      one.fail(fmt::format("has {} samples, but the row before has {}; make them equal", row->size(), all.cols()));
    all.row(j) = row->transpose();
  }
  return all;
}

Flight flight(const Field& field) {
  field.allow_only({"output_step", "input_step", "dt_step_s", "runs"});
  Flight flight{vector(field["output_step"]), vector(field["input_step"]), number(field["dt_step_s"])};
  const Field runs = field["runs"];
  const std::size_t size = runs.array_size();
  for (std::size_t i = 0; i < size; ++i) {
    const Field run = runs[i];
    run.allow_only({"outputs", "inputs", "dt"});
    FlightRun read{counts(run["outputs"], flight.output_step.size()), Eigen::MatrixXi(), Eigen::VectorXi()};
    if (run.has("inputs")) read.inputs = counts(run["inputs"], flight.input_step.size());
    if (run.has("dt")) read.dt = counts(run["dt"], 1).row(0);
    flight.runs.push_back(std::move(read));
    if (flight.samples() > kMostFlightSamples)
      runs.fail(fmt::format("have more than {} samples in total; leave some out", kMostFlightSamples));
  }
  return flight;
}

ErrorHead error_head(const Field& field) {
  field.allow_only({"weights", "bias", "log_min", "log_max", "factor_68", "factor_95"});
  return {matrix(field["weights"]), vector(field["bias"]),      vector(field["log_min"]),
          vector(field["log_max"]), vector(field["factor_68"]), vector(field["factor_95"])};
}

std::vector<std::pair<std::string, std::string>> facts(const Field& field) {
  field.expect(field.value.is_object(), "an object of texts");
  std::vector<std::pair<std::string, std::string>> list;
  for (const auto& [key, value] : field.value.items()) list.emplace_back(key, text({value, field.path + "." + key}));
  return list;
}

/// Returns the version of the file. Throws Error if the text is no model file or has a newer version than this program.
int version_of(const Field& file) {
  if (!file.value.is_object() || !file.value.contains("format") || file.value["format"] != "nlo-model")
    throw Error("is JSON but no nlo model (no \"format\": \"nlo-model\"); give the model.json that nlo train wrote");
  const Field version = file["version"];
  if (!version.value.is_number_integer())
    version.fail(fmt::format("is not a whole number; this nlo reads versions 1 to {}", kModelVersion));
  const double number = version.value.get<double>();  // an integer may be too large for int
  if (number > kModelVersion)
    version.fail(fmt::format("is {}; this nlo reads versions 1 to {}: a newer nlo wrote the file, update this one",
                             version.value.dump(), kModelVersion));
  if (number < 1)
    version.fail(fmt::format("is {}; this nlo reads versions 1 to {}", version.value.dump(), kModelVersion));
  return static_cast<int>(number);
}

const StructureModule& module_named_in(const Field& file) {
  const Field field = file["structure"];
  const StructureModule* module = find_structure(text(field));
  if (module == nullptr)
    field.fail("is unknown; there are " + names_of_structures([](const StructureModule&) { return true; }));
  return *module;
}

Model model_of(const Field& file) {
  const StructureModule& module = module_named_in(file);
  std::vector<const char*> keys = {
      "format",          "version",    "structure",      "name",       "outputs",    "states",
      "provenance",      "hold",       "initial_latent", "output_min", "output_max", "latent_min",
      "sample_period_s", "latent_max", "flight",         "inputs",     "input_hold", "input_min",
      "input_max",       "may_fail",   "saturation",     "monitor",    "error"};
  const std::vector<const char*> own = module.keys();
  keys.insert(keys.end(), own.begin(), own.end());
  file.allow_only(keys);

  Model m;
  m.name = text(file["name"]);
  m.outputs = channels(file["outputs"]);
  m.states = channels(file["states"]);
  if (file.has("inputs")) {
    m.inputs = channels(file["inputs"]);
    m.input_hold = hold(file["input_hold"]);
    m.input_min = vector(file["input_min"]);
    m.input_max = vector(file["input_max"]);
  }
  if (file.has("may_fail")) {
    const Field failures = file["may_fail"];
    failures.allow_only({"outputs", "rest", "staleness_s"});
    const Field outputs = failures["outputs"];
    for (std::size_t i = 0; i < outputs.array_size(); ++i) m.failures.outputs.push_back(small_integer(outputs[i]));
    m.failures.rest = vector(failures["rest"]);
    m.failures.staleness_s = number(failures["staleness_s"]);
  }
  m.provenance = facts(file["provenance"]);
  m.sample_period_s = number(file["sample_period_s"]);
  m.hold = hold(file["hold"]);
  m.initial_latent = vector(file["initial_latent"]);
  m.output_min = vector(file["output_min"]);
  m.output_max = vector(file["output_max"]);
  m.latent_min = vector(file["latent_min"]);
  m.latent_max = vector(file["latent_max"]);
  if (file.has("saturation")) m.saturation = number(file["saturation"]);
  module.read(file, m);
  if (file.has("monitor")) m.monitor = monitor(file["monitor"], m.nx());
  if (file.has("error")) m.error = error_head(file["error"]);
  if (file.has("flight")) m.flight = flight(file["flight"]);
  validate(m);
  return m;
}

/// Refuses text that the JSON library would accept: unlimited nesting, and duplicate keys, of which it would keep one.
class Guard {
 public:
  bool operator()(int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > kDeepest) throw Error(fmt::format("nests deeper than the {} levels of a model", kDeepest));
    auto& keys = keys_[static_cast<std::size_t>(depth)];
    if (event == Json::parse_event_t::object_start) keys_[static_cast<std::size_t>(depth) + 1].clear();
    if (event == Json::parse_event_t::key && !keys.insert(parsed.get<std::string>()).second)
      throw Error(
          fmt::format("{}: is given twice; remove one", parsed.dump(-1, ' ', true, Json::error_handler_t::replace)));
    return true;
  }

 private:
  std::array<std::set<std::string>, kDeepest + 2> keys_;
};

std::string line_and_column(std::string_view json, std::size_t byte) {
  const std::string_view before = json.substr(0, std::min(byte == 0 ? 0 : byte - 1, json.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const auto start = before.rfind('\n');
  return fmt::format("{}:{}", line, before.size() - (start == std::string_view::npos ? 0 : start + 1) + 1);
}

}  // namespace

Model parse_model(std::string_view json, const std::string& origin) {
  try {
    Json file = Json::parse(json, Guard());
    upgrade(file, version_of({file, ""}));
    return model_of({file, ""});
  } catch (const Error& error) {
    throw Error(origin + ": " + error.what());
  } catch (const Json::parse_error& error) {
    const bool ended = error.byte > json.size();
    throw Error(fmt::format("{}:{}: {}", origin, line_and_column(json, error.byte),
                            json.empty() ? "the file is empty; give the model.json that nlo train wrote"
                            : ended      ? "the file ends in the middle of the model; it was cut off, copy it again"
                                         : "is not JSON; give the model.json that nlo train wrote"));
  } catch (const Json::exception&) {
    throw Error(origin + ": holds a number beyond the range of double; write it smaller");
  }
}

}  // namespace nlo::codegen
