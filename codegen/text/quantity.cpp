// SPDX-License-Identifier: MIT
#include "codegen/text/quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "codegen/model/activations.h"

namespace nlo::codegen {
namespace {

std::vector<double> by_rows(const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd columns = values.transpose();
  return {columns.data(), columns.data() + columns.size()};
}

/// "drive.forward_map": what stands behind the last point.
std::string last_name(std::string_view field) {
  return std::string(field.substr(field.rfind('.') + 1));
}

/// "forward_map": "ForwardMap".
std::string in_capitals(const std::string& name) {
  std::string text;
  bool upper = true;
  for (const char c : name) {
    if (c != '_') text += upper ? static_cast<char>(c - 'a' + 'A') : c;
    upper = c == '_';
  }
  return text;
}

/// "make_mlp<Activation::kTanh>(weights::kLayer1,weights::kLayer2)", its parts apart.
std::vector<std::string> made(const FoldedNetwork& network, const std::string& layer, bool integers) {
  std::string layers;
  for (std::size_t l = 1; l <= network.layers.size(); ++l)
    layers += fmt::format("{}weights::k{}{}", l == 1 ? "" : ",", layer, l);
  return {integers ? "make_quantised_mlp" : "make_mlp", activation_row(network.activation).identifier,
          "(" + layers + ")"};
}

/// The function of C99 that evaluates it.
std::string caller(const FoldedNetwork& n, Quantities::Tables tables) {
  if (tables == Quantities::Tables::kMap) return "estimate";
  return last_name(n.field) + (tables == Quantities::Tables::kTangent ? "_tangent" : "");
}

/// "GatesLayer": "GatesNetwork".
std::string network_type(std::string layer) {
  return layer.replace(layer.rfind("Layer"), 5, "Network");
}

}  // namespace

void Quantities::add(Quantity quantity) {
  if (!quantity.cpp.empty() || !quantity.c99.empty()) all_.push_back(std::move(quantity));
}

void Quantities::scalar(std::string field, std::string cpp, std::string c99, double value) {
  add({std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kScalar, {}, {value}});
}

void Quantities::vector(std::string field, std::string cpp, std::string c99, const Eigen::VectorXd& values) {
  add({std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kScalar, {values.size()}, by_rows(values)});
}

void Quantities::matrix(std::string field, std::string cpp, std::string c99, const Eigen::MatrixXd& values) {
  add({std::move(field),
       std::move(cpp),
       std::move(c99),
       Quantity::Kind::kScalar,
       {values.rows(), values.cols()},
       by_rows(values)});
}

void Quantities::integer(std::string field, std::string cpp, std::string c99, double value) {
  add({std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kInteger, {}, {value}});
}

void Quantities::integers(std::string field, std::string cpp, std::string c99, const Eigen::MatrixXd& values) {
  add({std::move(field),
       std::move(cpp),
       std::move(c99),
       Quantity::Kind::kInteger,
       {values.rows(), values.cols()},
       by_rows(values)});
}

void Quantities::words(std::string field, std::string cpp, std::string c99, std::vector<std::string> words) {
  const auto count = static_cast<Eigen::Index>(words.size());
  add({std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kWords, {count}, {}, std::move(words)});
}

void Quantities::stack(std::string field, std::string cpp, std::string c99,
                       const std::vector<Eigen::MatrixXd>& values) {
  Quantity quantity{std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kScalar};
  quantity.shape = {static_cast<Eigen::Index>(values.size()), values.front().rows(), values.front().cols()};
  for (const Eigen::MatrixXd& matrix : values) {
    const std::vector<double> rows = by_rows(matrix);
    quantity.values.insert(quantity.values.end(), rows.begin(), rows.end());
  }
  add(std::move(quantity));
}

void Quantities::code(std::string field, std::string function, std::string words, bool so) {
  add({std::move(field), "", std::move(function), Quantity::Kind::kCode, {}, {so ? 1.0 : 0.0}, {std::move(words)}});
}

void Quantities::formula(std::string field, std::string cpp, std::string c99, Quantity::Arrays arrays,
                         std::function<void(Quantity::Arrays&)> formula) {
  Quantity quantity{std::move(field), std::move(cpp), std::move(c99), Quantity::Kind::kFormula};
  quantity.arrays = std::move(arrays);
  quantity.formula = std::move(formula);
  add(std::move(quantity));
}

void Quantities::network(std::string_view field, const std::string& layer, Tables tables) {
  const FoldedNetwork& n = source_.folded.network(field);
  const std::string member = last_name(field), name = std::string(field);
  const QuantisedNetwork* quantised = quantised_of(n);
  const bool integers = quantised != nullptr;
  const std::string prefix = tables == Tables::kMap ? "" : in_capitals(member);
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    layer_type(n, layer, l);
    if (integers && tables == Tables::kMap) continue;
    const std::string at = fmt::format("{}.layers[{}]", name, l), cpp = fmt::format("weights::k{}{}", layer, l + 1);
    const bool one = tables == Tables::kOneLayer, last = l + 1 == n.layers.size();
    const std::string number = one ? "" : std::to_string(l + 1);
    if (integers) {
      const QuantisedLayer& layer_in_integers = quantised->layers[l];
      this->integers(at + ".weights", cpp + ".weights", "k" + prefix, layer_in_integers.weights.cast<double>());
      this->integers(at + ".bias", cpp + ".bias", "k" + prefix + "Bias", layer_in_integers.bias.cast<double>());
      continue;
    }
    matrix(at + ".weights", cpp + ".weights", "k" + prefix + (one ? "" : "Weights") + number, n.layers[l].weights);
    // A derivative does not see the last bias.
    vector(at + ".bias", cpp + ".bias", tables == Tables::kTangent && last ? "" : "k" + prefix + "Bias" + number,
           n.layers[l].bias);
  }
  const std::vector<std::string> parts = made(n, layer, integers);
  words(name, "kModel." + member + ".mlp", "", {parts[0] + "<" + parts[1] + ">" + parts[2]});
  words(name, network_type(layer), "", {"decltype(" + parts[0], parts[1], parts[2] + ")"});
  if (integers && tables == Tables::kMap) {
    map_code(n);
    return integer_map(n);
  }
  if (tables == Tables::kMap && source_.folded.error) error_head();
  if (n.linear_path.size() != 0)
    matrix(name + ".skip", "kModel." + member + ".linear_path.weights", "k" + prefix + "LinearPath", n.linear_path);
  if (tables == Tables::kOneLayer) return;
  calls(n, prefix, tables);
  const bool tangent = tables == Tables::kTangent;
  if (tables == Tables::kMap) map_code(n);
  if (n.linear_path.size() != 0)
    code(name + ".skip", caller(n, tables),
         fmt::format("total+=k{}LinearPath[({}*o)+i]*{}[i];", prefix, n.inputs(), tangent ? "direction" : "in"), true);
  if (n.layers.size() > 1) activation_code(n, tangent);
}

const QuantisedNetwork* Quantities::quantised_of(const FoldedNetwork& n) const {
  if (source_.quantised == nullptr) return nullptr;
  if (n.field == "inverse_map") return &source_.quantised->map;
  if (!source_.quantised->units) return nullptr;
  return n.field == "gates" ? &source_.quantised->units->gates : &source_.quantised->units->candidate;
}

void Quantities::layer_type(const FoldedNetwork& n, const std::string& layer, std::size_t l) {
  const std::string at = fmt::format("{}.layers[{}]", n.field, l),
                    cpp = fmt::format("weights::k{}{}.type", layer, l + 1);
  const std::string rows = std::to_string(n.layers[l].weights.rows()),
                    columns = std::to_string(n.layers[l].weights.cols());
  if (const QuantisedNetwork* quantised = quantised_of(n)) {
    words(at, cpp, "", {"QuantisedDense", columns, rows, std::to_string(quantised->layers[l].shift)});
  } else {
    words(at, cpp, "", {"Dense", source_.init.weight_type(), columns, rows});
  }
}

void Quantities::integer_map(const FoldedNetwork& n) {
  const QuantisedNetwork& q = source_.quantised->map;
  std::string in = "in";
  for (std::size_t l = 0; l < q.layers.size(); ++l) {
    const QuantisedLayer& layer = q.layers[l];
    const std::string at = fmt::format("{}.layers[{}]", n.field, l), number = std::to_string(l + 1);
    integers(at + ".weights", "weights::kLayer" + number + ".weights", "kWeights" + number,
             layer.weights.cast<double>());
    integers(at + ".bias", "weights::kLayer" + number + ".bias", "kBias" + number, layer.bias.cast<double>());
    const bool last = l + 1 == q.layers.size();
    std::vector<std::string> call = {last ? "integer_dense" : "hidden", std::to_string(layer.weights.cols()),
                                     std::to_string(layer.weights.rows())};
    if (!last) call.push_back(std::to_string(layer.shift));
    call.insert(call.end(), {"kWeights" + number, "kBias" + number, "values", "sums"});
    words(at, "", "estimate#" + number, call);
  }
  const std::string member = "kModel.inverse_map.";
  vector("latent_min", member + "centre", "kCentre", q.centre.cast<double>());
  vector("latent_max", member + "gain", "kGain", q.gain.cast<double>());
  vector("inverse_map.layers", member + "scale", "kScale", q.scale.cast<double>());
  if (q.linear_path.size() != 0)
    matrix("inverse_map.skip", member + "linear_path.weights", "kLinearPath", q.linear_path.cast<double>());
  code("inverse_map.skip", "estimate", fmt::format("total+=kLinearPath[({}*o)+i]*in[i];", n.inputs()),
       q.linear_path.size() != 0);
  code("inverse_map", "estimate", "values[i]=quantised(in[i]-kCentre[i],kGain[i]);", true);
}

void Quantities::error_head() {
  const FoldedErrorHead& head = *source_.folded.error;
  const std::string constant = "weights::kErrorHead", member = "kModel.inverse_map.error.";
  words("error", constant + ".type", "",
        {"Dense", source_.init.scalar_name(), std::to_string(head.layer.weights.cols()),
         std::to_string(head.layer.weights.rows())});
  matrix("error.weights", constant + ".weights", "", head.layer.weights);
  vector("error.bias", constant + ".bias", "", head.layer.bias);
  words("error", member + "layer", "", {"pack(" + constant + ")"});
  vector("error.log_min", member + "lowest", "", head.lowest);
  vector("error.log_max", member + "highest", "", head.highest);
  vector("error.factor_95", member + "bound_95", "", head.bound_95);
}

std::string Quantities::map_type(const Map& map) const {
  const FoldedNetwork& n = source_.folded.network(map.field);
  const bool is_map = map.field == "inverse_map", integers = is_map && source_.quantised != nullptr;
  if (const QuantisedNetwork* quantised = quantised_of(n); quantised != nullptr && !is_map) {
    const std::string readings = quantised->centre.size() > 0 ? "," + std::to_string(quantised->centre.size()) : "";
    return "QuantisedUnits<" + network_type(map.layer) + readings + ">";
  }
  const auto& error = source_.folded.error;
  const std::string scalar = source_.init.scalar_name();
  const Eigen::Index out = n.layers.back().bias.size();
  std::string text = (integers ? "QuantisedMap<" : "LearnedMap<") + network_type(map.layer);
  if (n.linear_path.size() != 0) {
    text += fmt::format(",LinearPath<{},{},{}>", scalar, n.inputs(), out);
  } else if (is_map && error) {
    text += ",NoLinearPath";
  }
  if (is_map && error) text += fmt::format(",ErrorHead<{},{},{}>", scalar, error->layer.weights.cols() / 2, out);
  return text + ">";
}

void Quantities::types(const std::string& name, const std::vector<Eigen::Index>& sizes, const std::vector<Map>& maps,
                       bool may_saturate, const std::string& between) {
  const Model& m = source_.model;
  std::vector<std::string> parts = {name + "Model", source_.init.scalar_name()};
  for (const Eigen::Index size : sizes) parts.push_back(std::to_string(size));
  if (!between.empty()) parts.push_back(between);
  for (const Map& map : maps) parts.push_back(map_type(map));
  // From the last that is there on, those before it are written too.
  const std::vector<std::pair<bool, std::string>> more = {
      {!m.inputs.empty(), std::to_string(m.inputs.size())},
      {m.input_hold != Hold::kZeroOrder, hold_identifier(m.input_hold)},
      {!m.failures.none(), std::to_string(m.failures.outputs.size())},
      {m.saturates(), m.saturates() ? saturates_relative(m) ? "Saturation::kRelativeLatent" : "Saturation::kLatent"
                                    : "Saturation::kNone"},
      {m.measured() < m.ny(), "Computed"}};
  std::size_t count = more.size();
  while (count > 0 && !more[count - 1].first) --count;
  for (std::size_t i = 0; i < count; ++i)
    if (may_saturate || i != 3) parts.push_back(more[i].second);
  words("structure", "Model", "", parts);
  words("structure", "Observer", "", {name + "Observer", "Model"});
}

void Quantities::map_code(const FoldedNetwork& n) {
  const Model& m = source_.model;
  const std::string readings = m.nr() == m.ny() ? "kNy" : "kNr";
  code(n.field, "estimate", "copy(in+kNz,observer->y," + readings + ");", n.inputs() > m.nz());
}

void Quantities::activation_code(const FoldedNetwork& n, bool tangent) {
  const std::string name(activation_row(n.activation).name), f = source_.init.scalar_bytes() == 4 ? "f" : "";
  const std::string field = n.field + ".activation";
  const bool tanh = n.activation == Activation::kTanh, relu = n.activation == Activation::kRelu;
  const std::string function = tanh ? "tanh_rational" : name;
  if (!tangent) return code(field, name + "_layer", "out[o]=" + function + "(out[o]);", true);
  code(field, "tangent_layer", "a=" + function + "(v);", true);
  code(field, "tangent_layer", "tangent[o]*=1.0" + f + "-(a*a);", tanh);
  code(field, "tangent_layer", "tangent[o]*=(v>0.0" + f + ")?1.0" + f + ":0.0" + f + ";", relu);
}

/// Layer by layer through two buffers.
void Quantities::calls(const FoldedNetwork& n, const std::string& prefix, Tables tables) {
  const bool tangent = tables == Tables::kTangent;
  const std::string function = caller(n, tables);
  const std::string result = tables == Tables::kMap ? "x_hat" : "out";
  std::string in = "in", direction = "direction";
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const DenseLayer& layer = n.layers[l];
    const bool last = l + 1 == n.layers.size();
    const std::string number = std::to_string(l + 1), out = l % 2 == 0 ? "ping" : "pong";
    const std::string hidden = (tangent ? "tangent" : std::string(activation_row(n.activation).name)) + "_layer";
    std::vector<std::string> call = {last ? "dense" : hidden, std::to_string(layer.weights.cols()),
                                     std::to_string(layer.weights.rows()), "k" + prefix + "Weights" + number,
                                     tangent && last ? "kNoBias" : "k" + prefix + "Bias" + number};
    if (!tangent || !last) call.push_back(in);
    if (tangent) call.push_back(direction);
    call.push_back(last ? result : out);
    if (tangent && !last) call.push_back(out + "_tangent");
    words(fmt::format("{}.layers[{}]", n.field, l), "", function + "#" + number, call);
    in = out;
    direction = out + "_tangent";
  }
}

}  // namespace nlo::codegen
