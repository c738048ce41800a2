// SPDX-License-Identifier: MIT
#include "codegen/model/json_object.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codegen/base/error.h"
#include "codegen/model/activations.h"

namespace nlo::codegen {
namespace {

std::string rows(const Eigen::MatrixXd& matrix, const std::string& indent) {
  if (matrix.rows() == 0) return "[]";
  std::string text = "[";
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    text += (i == 0 ? "\n" : ",\n") + indent + "  " + json_array(matrix.row(i));
  return text + "\n" + indent + "]";
}

std::string layer_text(const DenseLayer& layer, const std::string& indent) {
  JsonObject object(indent);
  object.matrix("weights", layer.weights);
  object.vector("bias", layer.bias);
  return object.text();
}

}  // namespace

std::string json_text(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::exception&) {
    throw Error("a text in the model is not UTF-8; write names, units and provenance in UTF-8");
  }
}

void JsonObject::matrix(const char* name, const Eigen::MatrixXd& value) {
  field(name, rows(value, inner_));
}

void JsonObject::channels(const char* name, const std::vector<Channel>& list) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") + inner_ + "  {\"name\": " + json_text(list[i].name) +
            ", \"unit\": " + json_text(list[i].unit) + ", \"wrap\": " + literal(list[i].wrap) +
            (list[i].expression.empty() ? "" : ", \"expression\": " + json_text(list[i].expression)) +
            (list[i].period_s == 0.0 ? "" : ", \"period_s\": " + literal(list[i].period_s)) + "}";
  field(name, text + "\n" + inner_ + "]");
}

void JsonObject::dense(const char* name, const DenseLayer& layer) {
  field(name, layer_text(layer, inner_));
}

void JsonObject::network(const char* name, const Network& n) {
  JsonObject object(inner_);
  object.matrix("features", n.features);
  object.vector("feature_mean", n.feature_mean);
  object.vector("feature_scale", n.feature_scale);
  if (!n.feature_clocks.empty())
    object.field("feature_clocks",
                 fmt::format("[{}]", fmt::join(n.feature_clocks.begin(), n.feature_clocks.end(), ", ")));
  object.text("activation", activation_row(n.activation).name);
  std::string layers = "[";
  for (std::size_t i = 0; i < n.layers.size(); ++i)
    layers += (i == 0 ? "\n" : ",\n") + object.inner() + "  " + layer_text(n.layers[i], object.inner() + "  ");
  object.field("layers", layers + "\n" + object.inner() + "]");
  object.matrix("skip", n.skip);
  object.vector("output_mean", n.output_mean);
  object.vector("output_scale", n.output_scale);
  if (const std::vector<double>& largest = n.largest_activations; !largest.empty())
    object.vector("largest_activations",
                  Eigen::Map<const Eigen::VectorXd>(largest.data(), static_cast<Eigen::Index>(largest.size())));
  if (const Fallback& fallback = n.fallback; !fallback.outputs.empty()) {
    JsonObject part(object.inner());
    part.field("outputs", fmt::format("[{}]", fmt::join(fallback.outputs.begin(), fallback.outputs.end(), ", ")));
    part.matrix("rows", fallback.rows);
    part.vector("offset", fallback.offset);
    part.vector("reach", fallback.reach);
    object.field("fallback", part.text());
  }
  field(name, object.text());
}

}  // namespace nlo::codegen
