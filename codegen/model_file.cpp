// SPDX-License-Identifier: MIT
// The writing half and the entry points; model_reader.cpp has parse_model().
#include "codegen/model_file.h"

#include <nlohmann/json.hpp>

#include "codegen/error.h"
#include "codegen/file.h"
#include "codegen/number.h"
#include "codegen/validate.h"

namespace nlo::codegen {
namespace {

std::string quoted(const std::string& text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::exception&) {
    throw Error("a text in the model is not UTF-8; write names, units and provenance in UTF-8");
  }
}

template <class Vector>
std::string array(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + literal(values(i));
  return text + "]";
}

std::string rows(const Eigen::MatrixXd& matrix, const std::string& indent) {
  if (matrix.rows() == 0) return "[]";
  std::string text = "[";
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    text += (i == 0 ? "\n" : ",\n") + indent + "  " + array(matrix.row(i));
  return text + "\n" + indent + "]";
}

std::string channels(const std::vector<Channel>& list) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n    " : ",\n    ") + ("{\"name\": " + quoted(list[i].name)) +
            ", \"unit\": " + quoted(list[i].unit) + ", \"wrap\": " + literal(list[i].wrap) + "}";
  return text + "\n  ]";
}

std::string layers(const std::vector<DenseLayer>& list) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += std::string(i == 0 ? "\n" : ",\n") + "    {\n      \"weights\": " + rows(list[i].weights, "      ") +
            ",\n      \"bias\": " + array(list[i].bias) + "\n    }";
  return text + "\n  ]";
}

std::string facts(const std::vector<std::pair<std::string, std::string>>& list) {
  std::string text = "{";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n    " : ",\n    ") + quoted(list[i].first) + ": " + quoted(list[i].second);
  return text + (list.empty() ? "}" : "\n  }");
}

}  // namespace

std::string to_json(const Model& m) {
  std::string text = "{\n";
  const auto field = [&text](const char* name, const std::string& value) {
    text += std::string(text.size() > 2 ? ",\n" : "") + "  \"" + name + "\": " + value;
  };
  field("format", "\"nlo-model\"");
  field("version", "1");
  field("name", quoted(m.name));
  field("outputs", channels(m.outputs));
  field("states", channels(m.states));
  field("provenance", facts(m.provenance));
  field("sample_period_s", literal(m.sample_period_s));
  field("hold", quoted(m.hold));
  field("pairs", std::to_string(m.pairs));
  field("eigenvalues", array(m.eigenvalues));
  field("output_injection", rows(m.output_injection, "  "));
  field("initial_latent", array(m.initial_latent));
  field("starts_steady", m.starts_steady ? "true" : "false");
  field("output_min", array(m.output_min));
  field("output_max", array(m.output_max));
  field("latent_min", array(m.latent_min));
  field("latent_max", array(m.latent_max));
  field("features", rows(m.features, "  "));
  field("feature_mean", array(m.feature_mean));
  field("feature_scale", array(m.feature_scale));
  field("activation", quoted(m.activation));
  field("layers", layers(m.layers));
  field("skip", rows(m.skip, "  "));
  field("state_mean", array(m.state_mean));
  field("state_scale", array(m.state_scale));
  return text + "\n}\n";
}

void write_model(const Model& model, const std::string& path) {
  try {
    validate(model);
  } catch (const Error& error) {
    throw Error(path + ": not written: " + error.what());
  }
  write_file_atomically(path, to_json(model));
}

Model read_model(const std::string& path) {
  return parse_model(read_file(path), path);
}

}  // namespace nlo::codegen
