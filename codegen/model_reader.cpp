// SPDX-License-Identifier: MIT
// parse_model(): JSON to a validated model. Every field must be there (but a few that are asked for with has()), no
// other may be, and each has one type.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/error.h"
#include "codegen/model_file.h"
#include "codegen/model_upgrade.h"
#include "codegen/validate.h"

namespace nlo::codegen {
namespace {

using Json = nlohmann::ordered_json;  // provenance keeps its order

constexpr int kDeepest = 8;  // a model nests 7 levels: { drive { forward_map { layers [ { weights [ [

/// A value and its place in the file, for messages.
struct Field {
  const Json& value;
  std::string path;

  [[noreturn]] void fail(const std::string& what) const { throw Error(path + ": " + what); }

  void expect(bool is_expected, const char* kind) const {
    if (!is_expected) fail(fmt::format("is {}; expected {}", described(), kind));
  }

  std::string described() const {
    return value.is_null() ? "null (not finite when it was written?)" : std::string("a JSON ") + value.type_name();
  }

  Field operator[](const char* key) const {
    expect(value.is_object(), "an object");
    const auto found = value.find(key);
    const std::string name = path.empty() ? key : path + "." + key;
    if (found == value.end()) throw Error(name + ": is missing; export or train the model again");
    return {*found, name};
  }

  /// For the few that may be left out.
  bool has(const char* key) const { return value.is_object() && value.contains(key); }

  Field operator[](std::size_t i) const { return {value[i], fmt::format("{}[{}]", path, i)}; }

  std::size_t array_size() const {
    expect(value.is_array(), "an array");
    return value.size();
  }

  void allow_only(const std::vector<const char*>& keys) const {
    expect(value.is_object(), "an object");
    for (const auto& [key, unused] : value.items())
      if (std::none_of(keys.begin(), keys.end(), [&k = key](const char* known) { return k == known; }))
        throw Error(
            fmt::format("{}{}: unknown field; correct its spelling, or update nlo when a newer one wrote the file",
                        path.empty() ? "" : path + ".", Json(key).dump(-1, ' ', true, Json::error_handler_t::replace)));
  }
};

double number(const Field& field) {
  field.expect(field.value.is_number(), "a number");
  return field.value.get<double>();
}

std::string text(const Field& field) {
  field.expect(field.value.is_string(), "a text");
  return field.value.get<std::string>();
}

bool boolean(const Field& field) {
  field.expect(field.value.is_boolean(), "true or false");
  return field.value.get<bool>();
}

int small_integer(const Field& field) {
  constexpr int kLargest = 1 << 20;
  field.expect(field.value.is_number_integer(), "an integer");
  const double value = field.value.get<double>();
  if (!(value >= 0 && value <= kLargest)) field.fail(fmt::format("is {}; expected 0 to {}", value, kLargest));
  return static_cast<int>(value);
}

Eigen::VectorXd vector(const Field& field) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(field.array_size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values(i) = number(field[static_cast<std::size_t>(i)]);
  return values;
}

Eigen::MatrixXd matrix(const Field& field) {
  Eigen::MatrixXd values;
  const std::size_t rows = field.array_size();
  for (std::size_t i = 0; i < rows; ++i) {
    const Eigen::VectorXd row = vector(field[i]);
    if (i == 0) values.resize(static_cast<Eigen::Index>(rows), row.size());
    if (row.size() != values.cols())
      field[i].fail(
          fmt::format("has {} numbers and the rows above have {}; make them equal", row.size(), values.cols()));
    values.row(static_cast<Eigen::Index>(i)) = row.transpose();
  }
  return values;
}

std::vector<Channel> channels(const Field& field) {
  std::vector<Channel> list;
  const std::size_t size = field.array_size();
  for (std::size_t i = 0; i < size; ++i) {
    const Field channel = field[i];
    channel.allow_only({"name", "unit", "wrap"});
    list.push_back({text(channel["name"]), text(channel["unit"]), number(channel["wrap"])});
  }
  return list;
}

DenseLayer dense(const Field& field) {
  field.allow_only({"weights", "bias"});
  return {matrix(field["weights"]), vector(field["bias"])};
}

std::vector<DenseLayer> layers(const Field& field) {
  std::vector<DenseLayer> list;
  const std::size_t size = field.array_size();
  for (std::size_t i = 0; i < size; ++i) list.push_back(dense(field[i]));
  return list;
}

Network network(const Field& field) {
  field.allow_only({"features", "feature_mean", "feature_scale", "activation", "layers", "skip", "output_mean",
                    "output_scale", "largest_activations"});
  std::vector<double> largest;
  if (field.has("largest_activations")) {
    const Eigen::VectorXd values = vector(field["largest_activations"]);
    largest.assign(values.begin(), values.end());
  }
  return {.features = matrix(field["features"]),
          .feature_mean = vector(field["feature_mean"]),
          .feature_scale = vector(field["feature_scale"]),
          .activation = text(field["activation"]),
          .layers = layers(field["layers"]),
          .skip = matrix(field["skip"]),
          .output_mean = vector(field["output_mean"]),
          .output_scale = vector(field["output_scale"]),
          .largest_activations = largest};
}

LuenbergerDynamics luenberger(const Field& field) {
  field.allow_only({"state_matrix", "output_matrix", "gain", "nonlinearity"});
  return {matrix(field["state_matrix"]), matrix(field["output_matrix"]), matrix(field["gain"]),
          network(field["nonlinearity"])};
}

Drive drive(const Field& field) {
  field.allow_only({"inputs", "input_hold", "input_field", "forward_map"});
  return {channels(field["inputs"]), text(field["input_hold"]), dense(field["input_field"]),
          network(field["forward_map"])};
}

std::vector<std::pair<std::string, std::string>> facts(const Field& field) {
  field.expect(field.value.is_object(), "an object of texts");
  std::vector<std::pair<std::string, std::string>> list;
  for (const auto& [key, value] : field.value.items()) list.emplace_back(key, text({value, field.path + "." + key}));
  return list;
}

/// The version of the file, one that this program reads. Throws Error when it is no model file or a newer one.
int version_of(const Field& file) {
  if (!file.value.is_object() || !file.value.contains("format") || file.value["format"] != "nlo-model")
    throw Error("is JSON but no nlo model (no \"format\": \"nlo-model\"); give the model.json that nlo train wrote");
  const Field version = file["version"];
  if (!version.value.is_number_integer())
    version.fail(fmt::format("is no whole number; this nlo reads versions 1 to {}", kModelVersion));
  const double number = version.value.get<double>();  // whatever its size
  if (number > kModelVersion)
    version.fail(fmt::format("is {}; this nlo reads versions 1 to {}: a newer nlo wrote the file, update this one",
                             version.value.dump(), kModelVersion));
  if (number < 1)
    version.fail(fmt::format("is {}; this nlo reads versions 1 to {}", version.value.dump(), kModelVersion));
  return static_cast<int>(number);
}

/// The fields of a structure, beside those that all have.
struct Fields {
  std::string structure;
  std::vector<const char*> own;
};

const Fields& fields_of(const Field& file) {
  static const std::vector<Fields> known = {
      {"kkl", {"starts_steady", "pairs", "eigenvalues", "output_injection", "inverse_map"}},
      {"driven_kkl", {"starts_steady", "pairs", "eigenvalues", "output_injection", "inverse_map", "drive"}},
      {"luenberger", {"luenberger"}},
      {"general", {"dynamics", "inverse_map"}}};
  const Field field = file["structure"];
  const std::string name = text(field);
  for (const Fields& fields : known)
    if (fields.structure == name) return fields;
  field.fail("is unknown; there are kkl, driven_kkl, luenberger, general");
}

Model model_of(const Field& file) {
  const Fields& fields = fields_of(file);
  std::vector<const char*> keys = {
      "format", "version",        "structure",  "name",       "outputs",    "states",          "provenance",
      "hold",   "initial_latent", "output_min", "output_max", "latent_min", "sample_period_s", "latent_max"};
  keys.insert(keys.end(), fields.own.begin(), fields.own.end());
  file.allow_only(keys);
  const auto has = [&](std::string_view key) {
    return std::find(fields.own.begin(), fields.own.end(), key) != fields.own.end();
  };

  Model m;
  m.name = text(file["name"]);
  m.outputs = channels(file["outputs"]);
  m.states = channels(file["states"]);
  m.provenance = facts(file["provenance"]);
  m.sample_period_s = number(file["sample_period_s"]);
  m.hold = text(file["hold"]);
  m.initial_latent = vector(file["initial_latent"]);
  m.output_min = vector(file["output_min"]);
  m.output_max = vector(file["output_max"]);
  m.latent_min = vector(file["latent_min"]);
  m.latent_max = vector(file["latent_max"]);
  if (has("eigenvalues")) {
    m.starts_steady = boolean(file["starts_steady"]);
    m.pairs = small_integer(file["pairs"]);
    m.eigenvalues = vector(file["eigenvalues"]);
    m.output_injection = matrix(file["output_injection"]);
  }
  if (has("luenberger")) m.luenberger = luenberger(file["luenberger"]);
  if (has("dynamics")) m.dynamics = network(file["dynamics"]);
  if (has("drive")) m.drive = drive(file["drive"]);
  if (has("inverse_map")) m.inverse_map = network(file["inverse_map"]);
  validate(m);
  return m;
}

/// Refuses what the JSON library would take: nesting without end, and keys given twice (it keeps one of them).
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
