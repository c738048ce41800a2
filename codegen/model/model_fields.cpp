// SPDX-License-Identifier: MIT
#include "codegen/model/model_fields.h"

#include "codegen/model/activations.h"
#include "codegen/model/hold.h"

namespace nlo::codegen {

std::vector<Channel> channels(const Field& field) {
  std::vector<Channel> list;
  const std::size_t size = field.array_size();
  for (std::size_t i = 0; i < size; ++i) {
    const Field channel = field[i];
    channel.allow_only({"name", "unit", "wrap", "expression", "period_s"});
    list.push_back({text(channel["name"]), text(channel["unit"]), number(channel["wrap"]),
                    channel.has("expression") ? text(channel["expression"]) : "",
                    channel.has("period_s") ? number(channel["period_s"]) : 0.0});
  }
  return list;
}

DenseLayer dense(const Field& field) {
  field.allow_only({"weights", "bias"});
  return {matrix(field["weights"]), vector(field["bias"])};
}

namespace {

std::vector<DenseLayer> layers(const Field& field) {
  std::vector<DenseLayer> list;
  const std::size_t size = field.array_size();
  for (std::size_t i = 0; i < size; ++i) list.push_back(dense(field[i]));
  return list;
}

Activation activation(const Field& field) {
  const ActivationRow* row = find_activation(text(field));
  if (row == nullptr) throw Error(fmt::format("{} is unknown; use {}", field.path, activations_in_words()));
  return row->kind;
}

Fallback fallback(const Field& field) {
  field.allow_only({"outputs", "rows", "offset", "reach"});
  Fallback result{{}, matrix(field["rows"]), vector(field["offset"]), vector(field["reach"])};
  const Field list = field["outputs"];
  if (list.array_size() == 0) throw Error(fmt::format("{} is empty; leave fallback out", list.path));
  for (std::size_t f = 0; f < list.array_size(); ++f) result.outputs.push_back(small_integer(list[f]));
  return result;
}

}  // namespace

Network network(const Field& field) {
  field.allow_only({"features", "feature_mean", "feature_scale", "feature_clocks", "activation", "layers", "skip",
                    "output_mean", "output_scale", "largest_activations", "fallback"});
  std::vector<double> largest;
  if (field.has("largest_activations")) {
    const Eigen::VectorXd values = vector(field["largest_activations"]);
    largest.assign(values.begin(), values.end());
  }
  std::vector<int> clocks;
  if (field.has("feature_clocks")) {
    const Field list = field["feature_clocks"];
    for (std::size_t f = 0; f < list.array_size(); ++f)
      clocks.push_back(number(list[f]) == -1.0 ? -1 : small_integer(list[f]));
  }
  return {.features = matrix(field["features"]),
          .feature_mean = vector(field["feature_mean"]),
          .feature_scale = vector(field["feature_scale"]),
          .feature_clocks = clocks,
          .activation = activation(field["activation"]),
          .layers = layers(field["layers"]),
          .skip = matrix(field["skip"]),
          .output_mean = vector(field["output_mean"]),
          .output_scale = vector(field["output_scale"]),
          .largest_activations = largest,
          .fallback = field.has("fallback") ? fallback(field["fallback"]) : Fallback{}};
}

Hold hold(const Field& field) {
  const std::optional<Hold> named = find_hold(text(field));
  if (!named) throw Error(field.path + " is unknown; use zero_order, first_order or rk4");
  return *named;
}

}  // namespace nlo::codegen
