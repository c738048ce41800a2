// SPDX-License-Identifier: MIT
#include "codegen/model/field_checks.h"

#include <cmath>

#include "codegen/base/identifier.h"
#include "codegen/model/activations.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"

namespace nlo::codegen {

void check_shape(const Eigen::MatrixXd& m, Eigen::Index rows, Eigen::Index cols, const std::string& field,
                 const char* meaning) {
  if (m.rows() != rows || m.cols() != cols)
    fail("{} is {} x {}; it must be {} x {} ({})", field, m.rows(), m.cols(), rows, cols, meaning);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < cols; ++j)
      if (!std::isfinite(m(i, j)))
        fail("{}[{}][{}] is not finite ({}); train again, or use the last good checkpoint", field, i, j, m(i, j));
}

void check_shape(const Eigen::VectorXd& v, Eigen::Index size, const std::string& field, const char* meaning) {
  if (v.size() != size) fail("{} has {} entries; it must have {} ({})", field, v.size(), size, meaning);
  for (Eigen::Index i = 0; i < size; ++i)
    if (!std::isfinite(v(i)))
      fail("{}[{}] is not finite ({}); train again, or use the last good checkpoint", field, i, v(i));
}

void check_positive(const Eigen::VectorXd& v, const std::string& field) {
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (!(v(i) > 0.0)) fail("{}[{}] is {}; a scale must be positive", field, i, v(i));
}

void check_range(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const char* field) {
  for (Eigen::Index i = 0; i < low.size(); ++i)
    if (!(low(i) < high(i)))
      fail("{0}_min[{1}] is {2} and {0}_max[{1}] is {3}; the minimum must be smaller", field, i, low(i), high(i));
  for (Eigen::Index i = 0; i < low.size(); ++i)
    if (!(low(i) >= -kLargestNumber && high(i) <= kLargestNumber))
      fail("{0}_min[{1}] is {2} and {0}_max[{1}] is {3}; float32 requires them within +-{4}", field, i, low(i), high(i),
           kLargestNumber);
}

void check_channels(const std::vector<Channel>& channels, const std::string& field) {
  if (channels.empty()) fail("{} is empty; a model has at least one of them", field);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Channel& channel = channels[i];
    if (!is_identifier(channel.name))
      fail(
          "{}[{}].name is not an identifier; use a letter, then letters, digits and underscores (63 at most), no C++ "
          "keyword",
          field, i);
    if (!(channel.wrap >= 0.0) || !std::isfinite(channel.wrap))
      fail("{}[{}].wrap is {}; give the full turn of an angle in its unit (6.283185307179586 for rad), or 0", field, i,
           channel.wrap);
    if (channel.wrap != 0.0 && !(channel.wrap >= kSmallestNumber && channel.wrap <= kLargestNumber))
      fail("{}[{}].wrap is {}; float32 requires it from {} to {}", field, i, channel.wrap, kSmallestNumber,
           kLargestNumber);
    for (std::size_t j = 0; j < i; ++j)
      if (channels[j].name == channel.name)
        fail("{0}[{1}].name and {0}[{2}].name are both \"{3}\"; rename one", field, j, i, channel.name);
  }
}

namespace {

void check_fallback(const Fallback& fallback, Eigen::Index nu, int outputs, const std::string& field) {
  const auto of = [&field](const char* part) { return field + "." + part; };
  const auto count = static_cast<Eigen::Index>(fallback.outputs.size());
  for (std::size_t f = 0; f < fallback.outputs.size(); ++f) {
    const int least = f == 0 ? 0 : fallback.outputs[f - 1] + 1;
    if (fallback.outputs[f] < least || fallback.outputs[f] >= outputs)
      codegen::fail("{}[{}] is {}; write numbers of outputs, from 0 to {}, in increasing order", of("outputs"), f,
                    fallback.outputs[f], outputs - 1);
  }
  check_shape(fallback.rows, count, nu, of("rows"), "one row for each of fallback.outputs x n_u");
  check_shape(fallback.offset, count, of("offset"), "one for each of fallback.outputs");
  check_shape(fallback.reach, count, of("reach"), "one for each of fallback.outputs");
  for (Eigen::Index f = 0; f < count; ++f)
    if (!(fallback.reach(f) >= kSmallestNumber && fallback.reach(f) <= kLargestNumber))
      codegen::fail("{}[{}] is {}; a distance must be positive, from {} to {}", of("reach"), f, fallback.reach(f),
                    kSmallestNumber, kLargestNumber);
}

}  // namespace

void check_network(const Network& n, int inputs, int outputs, const std::string& field, const char* meaning) {
  const auto of = [&field](const char* part) { return field + "." + part; };
  const auto nu = n.features.rows();
  if (nu == 0) fail("{} is empty; the network must read something", of("features"));
  check_shape(n.features, nu, inputs, of("features"), meaning);
  check_shape(n.feature_mean, nu, of("feature_mean"), "n_u, the rows of features");
  check_shape(n.feature_scale, nu, of("feature_scale"), "n_u, the rows of features");
  check_positive(n.feature_scale, of("feature_scale"));
  if (!n.feature_clocks.empty() && static_cast<Eigen::Index>(n.feature_clocks.size()) != nu)
    fail("{} has {} entries; it must have {} (the rows of features), or be left out", of("feature_clocks"),
         n.feature_clocks.size(), nu);
  if (!activation_row(n.activation).is_trained())
    fail("{} is {}, which only an export may choose; use {}", of("activation"), activation_row(n.activation).name,
         activations_in_words());

  if (n.layers.empty()) fail("{} is empty; a linear map is one layer", of("layers"));
  Eigen::Index reads = nu;
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const bool last = l + 1 == n.layers.size();
    const DenseLayer& layer = n.layers[l];
    const auto rows = last ? static_cast<Eigen::Index>(outputs) : layer.weights.rows();
    if (rows == 0) fail("{}.layers[{}].weights is empty; a layer has at least one neuron", field, l);
    check_shape(layer.weights, rows, reads, fmt::format("{}.layers[{}].weights", field, l),
                last ? "n_out x the neurons of the layer before" : "neurons x what the layer reads");
    check_shape(layer.bias, rows, fmt::format("{}.layers[{}].bias", field, l), "the rows of its weights");
    reads = rows;
  }
  if (n.skip.size() != 0 || n.skip.rows() != 0)
    check_shape(n.skip, outputs, nu, of("skip"), "n_out x n_u, or [] for none");
  check_shape(n.output_mean, outputs, of("output_mean"), "n_out");
  check_shape(n.output_scale, outputs, of("output_scale"), "n_out");
  check_positive(n.output_scale, of("output_scale"));
  if (!n.fallback.outputs.empty()) check_fallback(n.fallback, nu, outputs, of("fallback"));
  const std::vector<double>& largest = n.largest_activations;
  if (!largest.empty() && largest.size() + 1 != n.layers.size())
    fail("{} has {} numbers; it must have one for each of the {} hidden layers, or be left out",
         of("largest_activations"), largest.size(), n.layers.size() - 1);
  for (std::size_t l = 0; l < largest.size(); ++l)
    if (!(largest[l] >= 0.0) || !std::isfinite(largest[l]))
      fail("{}[{}] is {}; it must be finite and not negative", of("largest_activations"), l, largest[l]);
}

void check_sums(const Network& n, const Eigen::VectorXd& largest, const std::string& field) {
  const ActivationRow& activation = activation_row(n.activation);
  Eigen::VectorXd inputs = (n.features.cwiseAbs() * largest + n.feature_mean.cwiseAbs()).cwiseQuotient(n.feature_scale);
  multiply_by_clocks(inputs, largest, n.feature_clocks);
  if (const Fallback& fallback = n.fallback; !fallback.outputs.empty()) {
    const Eigen::VectorXd rows = fallback.rows.cwiseAbs() * inputs + fallback.offset.cwiseAbs();
    for (Eigen::Index f = 0; f < rows.size(); ++f)
      if (!(rows(f) < kLargestNumber))
        fail("{}.fallback.rows[{}] may add up to {} within the ranges of the readings; it must stay below {}", field, f,
             rows(f), kLargestNumber);
  }
  Eigen::VectorXd reads = inputs;
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const bool last = l + 1 == n.layers.size();
    Eigen::VectorXd sums = n.layers[l].weights.cwiseAbs() * reads + n.layers[l].bias.cwiseAbs();
    if (last && n.skip.size() != 0) sums += n.skip.cwiseAbs() * inputs;
    if (last) sums = n.output_scale.cwiseProduct(sums) + n.output_mean.cwiseAbs();
    for (Eigen::Index i = 0; i < sums.size(); ++i)
      if (!(sums(i) < kLargestNumber))
        fail("{}.layers[{}].weights[{}] may add up to {} within the ranges of the readings; it must stay below {}",
             field, l, i, sums(i), kLargestNumber);
    reads = sums.cwiseMin(activation.largest_value);
  }
}

std::vector<SeenChange> seen_of_turn(const Model& m, int output) {
  // Rounding in features * [S; I] is a few units in the last place of its largest term. A feature that really reads an
  // angle changes by a fraction of that term.
  constexpr double kTurnTolerance = 1e-9;
  const Eigen::MatrixXd& features = inverse_map(m)->features;
  Eigen::VectorXd turn = Eigen::VectorXd::Zero(m.nz() + m.nr());
  turn.head(m.nz()) = steady_gain(m).col(output);
  turn(m.nz() + output) = 1.0;
  const Eigen::VectorXd seen = features * turn;
  // Relative to the largest entry of S, because the quadrature row of a unit-gain pair is zero up to rounding.
  const Eigen::VectorXd largest = features.rowwise().lpNorm<1>() * turn.lpNorm<Eigen::Infinity>();
  std::vector<SeenChange> changes;
  for (Eigen::Index i = 0; i < seen.size(); ++i)
    if (std::abs(seen(i)) > kTurnTolerance * largest(i)) changes.push_back({i, seen(i)});
  return changes;
}

Eigen::VectorXd largest_readings(const Model& m) {
  const FlownRanges flown = flown_ranges(m);
  return flown.min.cwiseAbs().cwiseMax(flown.max.cwiseAbs()) + flown.wrap;
}

void check_no_angles(const Model& m) {
  for (std::size_t j = 0; j < m.outputs.size(); ++j)
    if (m.outputs[j].wrap != 0.0)
      fail(
          "outputs[{}].wrap is {}; only a KKL observer can follow an unwrapped angle: give its sine and cosine as "
          "outputs",
          j, m.outputs[j].wrap);
}

}  // namespace nlo::codegen
