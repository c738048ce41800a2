// SPDX-License-Identifier: MIT
// The writing half and the entry points; model_reader.cpp has parse_model().
#include "codegen/model_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "codegen/error.h"
#include "codegen/file.h"
#include "codegen/model_upgrade.h"
#include "codegen/number.h"
#include "codegen/validate.h"
#include "codegen/vlq.h"

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

std::string channels(const std::vector<Channel>& list, const std::string& indent) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") + indent + "  {\"name\": " + quoted(list[i].name) +
            ", \"unit\": " + quoted(list[i].unit) + ", \"wrap\": " + literal(list[i].wrap) + "}";
  return text + "\n" + indent + "]";
}

std::string facts(const std::vector<std::pair<std::string, std::string>>& list) {
  std::string text = "{";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n    " : ",\n    ") + quoted(list[i].first) + ": " + quoted(list[i].second);
  return text + (list.empty() ? "}" : "\n  }");
}

/// A JSON object, one field per line.
class Object {
 public:
  explicit Object(std::string indent) : indent_(std::move(indent)) {}

  const std::string& inner() const { return inner_; }
  void field(const char* name, const std::string& value) {
    text_ += std::string(text_.empty() ? "{\n" : ",\n") + inner_ + "\"" + name + "\": " + value;
  }
  void matrix(const char* name, const Eigen::MatrixXd& value) { field(name, rows(value, inner_)); }
  std::string text() const { return text_ + "\n" + indent_ + "}"; }

 private:
  std::string indent_, inner_ = indent_ + "  ", text_;
};

std::string dense(const DenseLayer& layer, const std::string& indent) {
  Object object(indent);
  object.matrix("weights", layer.weights);
  object.field("bias", array(layer.bias));
  return object.text();
}

std::string layers(const std::vector<DenseLayer>& list, const std::string& indent) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") + indent + "  " + dense(list[i], indent + "  ");
  return text + "\n" + indent + "]";
}

std::string network(const Network& n, const std::string& indent) {
  Object object(indent);
  object.matrix("features", n.features);
  object.field("feature_mean", array(n.feature_mean));
  object.field("feature_scale", array(n.feature_scale));
  object.field("activation", quoted(n.activation));
  object.field("layers", layers(n.layers, object.inner()));
  object.matrix("skip", n.skip);
  object.field("output_mean", array(n.output_mean));
  object.field("output_scale", array(n.output_scale));
  if (const std::vector<double>& largest = n.largest_activations; !largest.empty())
    object.field("largest_activations",
                 array(Eigen::Map<const Eigen::VectorXd>(largest.data(), static_cast<Eigen::Index>(largest.size()))));
  return object.text();
}

std::string luenberger(const LuenbergerDynamics& l, const std::string& indent) {
  Object object(indent);
  object.matrix("state_matrix", l.state_matrix);
  object.matrix("output_matrix", l.output_matrix);
  object.matrix("gain", l.gain);
  object.field("nonlinearity", network(l.nonlinearity, object.inner()));
  return object.text();
}

std::string drive(const Drive& d, const std::string& indent) {
  Object object(indent);
  object.field("inputs", channels(d.inputs, object.inner()));
  object.field("input_hold", quoted(d.input_hold));
  object.field("input_field", dense(d.input_field, object.inner()));
  object.field("forward_map", network(d.forward_map, object.inner()));
  return object.text();
}

std::string counts(const Eigen::MatrixXi& channels) {
  std::string text = "[";
  for (Eigen::Index j = 0; j < channels.rows(); ++j)
    text += std::string(j == 0 ? "\"" : ", \"") + to_vlq(channels.row(j)) + "\"";
  return text + "]";
}

std::string flight(const Flight& f, const std::string& indent) {
  Object object(indent);
  object.field("output_step", array(f.output_step));
  object.field("input_step", array(f.input_step));
  object.field("dt_step_s", literal(f.dt_step_s));
  std::string runs = "[";
  for (const FlightRun& run : f.runs) {
    runs += (runs.size() == 1 ? "\n" : ",\n") + object.inner() + "  {\"outputs\": " + counts(run.outputs);
    if (run.inputs.size() != 0) runs += ", \"inputs\": " + counts(run.inputs);
    if (run.dt.size() != 0) runs += ", \"dt\": " + counts(run.dt.transpose());
    runs += "}";
  }
  object.field("runs", runs + "\n" + object.inner() + "]");
  return object.text();
}

}  // namespace

std::string to_json(const Model& m) {
  Object object("");
  object.field("format", "\"nlo-model\"");
  object.field("version", std::to_string(kModelVersion));
  object.field("structure", quoted(std::string(structure(m))));
  object.field("name", quoted(m.name));
  object.field("outputs", channels(m.outputs, object.inner()));
  object.field("states", channels(m.states, object.inner()));
  object.field("provenance", facts(m.provenance));
  object.field("sample_period_s", literal(m.sample_period_s));
  object.field("hold", quoted(m.hold));
  object.field("initial_latent", array(m.initial_latent));
  object.field("output_min", array(m.output_min));
  object.field("output_max", array(m.output_max));
  object.field("latent_min", array(m.latent_min));
  object.field("latent_max", array(m.latent_max));
  if (has_linear_latent(m)) {
    object.field("starts_steady", m.starts_steady ? "true" : "false");
    if (!m.relative_outputs.empty())
      object.field("relative_outputs",
                   fmt::format("[{}]", fmt::join(m.relative_outputs.begin(), m.relative_outputs.end(), ", ")));
    object.field("pairs", std::to_string(m.pairs));
    object.field("eigenvalues", array(m.eigenvalues));
    object.matrix("output_injection", m.output_injection);
  }
  if (m.luenberger) object.field("luenberger", luenberger(*m.luenberger, object.inner()));
  if (m.dynamics) object.field("dynamics", network(*m.dynamics, object.inner()));
  if (m.drive) object.field("drive", drive(*m.drive, object.inner()));
  if (!m.luenberger) object.field("inverse_map", network(m.inverse_map, object.inner()));
  if (!m.flight.runs.empty()) object.field("flight", flight(m.flight, object.inner()));
  return object.text() + "\n";
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
