// SPDX-License-Identifier: MIT
// parse_model(): JSON to a validated model. Every field must be there, no other may be, and each has one type.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "codegen/error.h"
#include "codegen/model_file.h"
#include "codegen/validate.h"

namespace nlo::codegen {
namespace {

using Json = nlohmann::ordered_json;  // provenance keeps its order

constexpr int kDeepest = 8;  // a model nests 4 levels: { layers [ { weights [ [

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

  Field operator[](std::size_t i) const { return {value[i], fmt::format("{}[{}]", path, i)}; }

  std::size_t array_size() const {
    expect(value.is_array(), "an array");
    return value.size();
  }

  void allow_only(std::initializer_list<const char*> keys) const {
    expect(value.is_object(), "an object");
    for (const auto& [key, unused] : value.items())
      if (std::none_of(keys.begin(), keys.end(), [&k = key](const char* known) { return k == known; }))
        throw Error(fmt::format("{}{}: unknown field; remove it or correct its spelling",
                                path.empty() ? "" : path + ".",
                                Json(key).dump(-1, ' ', true, Json::error_handler_t::replace)));
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

std::vector<DenseLayer> layers(const Field& field) {
  std::vector<DenseLayer> list;
  const std::size_t size = field.array_size();
  for (std::size_t i = 0; i < size; ++i) {
    const Field layer = field[i];
    layer.allow_only({"weights", "bias"});
    list.push_back({matrix(layer["weights"]), vector(layer["bias"])});
  }
  return list;
}

std::vector<std::pair<std::string, std::string>> facts(const Field& field) {
  field.expect(field.value.is_object(), "an object of texts");
  std::vector<std::pair<std::string, std::string>> list;
  for (const auto& [key, value] : field.value.items()) list.emplace_back(key, text({value, field.path + "." + key}));
  return list;
}

void check_format(const Field& file) {
  if (!file.value.is_object() || !file.value.contains("format") || file.value["format"] != "nlo-model")
    throw Error("is JSON but no nlo model (no \"format\": \"nlo-model\"); give the model.json that nlo train wrote");
  const Field version = file["version"];
  if (version.value == 1) return;
  version.fail(fmt::format("is {}; this nlo reads version 1: use the nlo that wrote the file, or train again",
                           version.value.is_number() ? version.value.dump() : "no number"));
}

Model model_of(const Field& file) {
  check_format(file);
  file.allow_only({"format",           "version",         "name",          "outputs",      "states",
                   "provenance",       "sample_period_s", "hold",          "pairs",        "eigenvalues",
                   "output_injection", "initial_latent",  "starts_steady", "output_min",   "output_max",
                   "latent_min",       "latent_max",      "features",      "feature_mean", "feature_scale",
                   "activation",       "layers",          "skip",          "state_mean",   "state_scale"});
  Model m;
  m.name = text(file["name"]);
  m.outputs = channels(file["outputs"]);
  m.states = channels(file["states"]);
  m.provenance = facts(file["provenance"]);
  m.sample_period_s = number(file["sample_period_s"]);
  m.hold = text(file["hold"]);
  m.pairs = small_integer(file["pairs"]);
  m.eigenvalues = vector(file["eigenvalues"]);
  m.output_injection = matrix(file["output_injection"]);
  m.initial_latent = vector(file["initial_latent"]);
  m.starts_steady = boolean(file["starts_steady"]);
  m.output_min = vector(file["output_min"]);
  m.output_max = vector(file["output_max"]);
  m.latent_min = vector(file["latent_min"]);
  m.latent_max = vector(file["latent_max"]);
  m.features = matrix(file["features"]);
  m.feature_mean = vector(file["feature_mean"]);
  m.feature_scale = vector(file["feature_scale"]);
  m.activation = text(file["activation"]);
  m.layers = layers(file["layers"]);
  m.skip = matrix(file["skip"]);
  m.state_mean = vector(file["state_mean"]);
  m.state_scale = vector(file["state_scale"]);
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
    const Json file = Json::parse(json, Guard());
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
