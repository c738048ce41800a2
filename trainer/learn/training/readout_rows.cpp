// SPDX-License-Identifier: MIT
#include "trainer/learn/training/readout_rows.h"

#include <cmath>
#include <limits>
#include <utility>

#include "codegen/replay/reference_observer.h"
#include "trainer/base/ridge.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RowInputs::RowInputs(const codegen::Model& model, const SampledTruth& training) {
  const codegen::Network* map = codegen::inverse_map(model);
  const Index both = model.nz() + model.nr();
  if (map != nullptr) {
    of_ = map->features;
    mean_ = map->feature_mean;
    scale_ = map->feature_scale;
    clocks_ = map->feature_clocks;
  } else {
    of_ = MatrixXd::Identity(both, both);
    mean_ = VectorXd::Zero(both);
    scale_ = VectorXd::Ones(both);
  }
  features_ = of_.rows();
  // If T* saturates, a direct reading would continue outside of the domain.
  if (map == nullptr || of_.cols() != both || model.saturates()) return;
  const auto channels = codegen::readings(model);
  for (int j = 0; j < model.ny() + static_cast<int>(model.inputs.size()); ++j) {
    if (channels[static_cast<std::size_t>(j)].wrap > 0.0 || codegen::is_relative(model, j)) continue;
    VectorXd row = VectorXd::Zero(both);
    row(model.nz() + j) = 1.0;
    const VectorXd values = training.y.row(j);
    append(row, values.mean(), std::sqrt((values.array() - values.mean()).square().mean()));
    readings_.push_back(j);
  }
}

VectorXd RowInputs::reading_alone(std::size_t index) const {
  VectorXd row = VectorXd::Zero(1 + all());
  const Index at = features_ + static_cast<Index>(index);
  row(0) = mean_(at);
  row(1 + at) = scale_(at);
  return row;
}

MatrixXd RowInputs::values(const SampledTruth& samples) const {
  MatrixXd u = of_.leftCols(samples.z.rows()) * samples.z;
  if (of_.cols() > samples.z.rows()) u += of_.rightCols(samples.y.rows()) * samples.y;
  u = ((u.colwise() - mean_).array().colwise() / scale_.array()).matrix();
  codegen::multiply_by_clocks(u, samples.z, clocks_);
  return u;
}

void RowInputs::extend(codegen::Network& map) const {
  map.features = of_;
  map.feature_mean = mean_;
  map.feature_scale = scale_;
  map.feature_clocks = clocks_;
  MatrixXd& first = map.layers.front().weights;
  first.conservativeResizeLike(MatrixXd::Zero(first.rows(), all()));
  if (map.skip.size() != 0) map.skip.conservativeResizeLike(MatrixXd::Zero(map.skip.rows(), all()));
}

void RowInputs::append(const VectorXd& row, double mean, double deviation) {
  const Index at = of_.rows();
  of_.conservativeResize(at + 1, Eigen::NoChange);
  of_.row(at) = row.transpose();
  mean_.conservativeResize(at + 1);
  scale_.conservativeResize(at + 1);
  mean_(at) = mean;
  scale_(at) = deviation > 1e-12 ? deviation : 1.0;
  if (!clocks_.empty()) clocks_.push_back(-1);
}

std::vector<RowCandidate> row_candidates(const codegen::Model& model, const RowInputs& inputs,
                                         const SampledTruth& training) {
  const MatrixXd u = inputs.values(training);
  std::vector<RowCandidate> result;
  const auto fit = [&](Index columns) {
    Ridge ridge;
    TransientRidge of_products;
    if (inputs.has_clocks())
      of_products.add(u.topRows(columns), training.x, training.weights, training.since_start);
    else
      ridge.add(u.topRows(columns), training.x, training.weights);
    for (const double strength : kRidges) {
      MatrixXd rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
      rows.leftCols(1 + columns) = inputs.has_clocks() ? of_products.fit(strength) : ridge.fit(strength);
      result.push_back({std::move(rows), columns > inputs.features()});
    }
  };
  fit(inputs.features());
  MatrixXd constant = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  constant.col(0) = training.x * training.weights / training.weights.sum();
  result.push_back({std::move(constant), false});
  if (inputs.readings().empty()) return result;
  fit(inputs.all());
  for (std::size_t j = 0; j < inputs.readings().size(); ++j) {
    const MatrixXd rows = inputs.reading_alone(j).transpose().replicate(model.nx(), 1);
    result.push_back({rows, true});
  }
  return result;
}

SetSquares squares_of(const codegen::Model& model, const RowInputs& inputs, const std::vector<RowCandidate>& all,
                      const SampledTruth& samples) {
  const codegen::ReferenceObserver<float> observer(model);
  const MatrixXd of_map = errors_of(observer.estimates(samples.z, samples.y), samples.x, model.states);
  const MatrixXd u = with_one(inputs.values(samples));
  const VectorXd& w = samples.weights;
  const auto mean = [&](const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b) {
    return a.cwiseProduct(b).dot(w.transpose()) / w.sum();
  };
  SetSquares result;
  for (Index i = 0; i < model.nx(); ++i) {
    const codegen::Channel& state = model.states[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd truth = samples.x.row(i);
    const auto errors = [&](const Eigen::RowVectorXd& estimate) -> Eigen::RowVectorXd {
      return errors_of(estimate, truth, {state});
    };
    StateSquares& squares = result.emplace_back();
    squares.map = mean(of_map.row(i), of_map.row(i));
    for (const RowCandidate& candidate : all) {
      const Eigen::RowVectorXd of_row = errors(candidate.rows.row(i) * u);
      squares.row.push_back(mean(of_row, of_row));
      squares.both.push_back(mean(of_row, of_map.row(i)));
    }
    for (int j = 0; j < model.ny(); ++j) {
      const bool measures = j < model.measured() && model.outputs[static_cast<std::size_t>(j)].unit == state.unit;
      const Eigen::RowVectorXd of_sensor = measures ? errors(samples.y.row(j)) : truth;
      squares.reading.push_back(measures ? mean(of_sensor, of_sensor) : std::numeric_limits<double>::infinity());
    }
    const Eigen::RowVectorXd off = truth.array() - truth.dot(w.transpose()) / w.sum();
    squares.deviation = mean(off, off);
  }
  return result;
}

SetSquares left_out_squares(const codegen::Model& model, const Rollout& training, const Rollout& left_out) {
  const SampledTruth fitted = sample_truth(model, training, kReadoutSamples),
                     judged = sample_truth(model, left_out, kReadoutSamples);
  if (fitted.weights.size() == 0 || judged.weights.size() == 0) return {};
  const RowInputs inputs(model, fitted);
  return squares_of(model, inputs, row_candidates(model, inputs, fitted), judged);
}

void write_readout(codegen::Network& map, const RowInputs& inputs, const VectorXd& shares, const MatrixXd& rows,
                   bool reads_more, bool keep_hidden) {
  if (reads_more) inputs.extend(map);
  const Index columns = map.features.rows();
  codegen::DenseLayer& last = map.layers.back();
  if (map.skip.size() == 0) map.skip = MatrixXd::Zero(shares.size(), columns);
  for (Index i = 0; i < shares.size(); ++i) {
    const double share = shares(i), scale = map.output_scale(i);
    if (share == 1.0) continue;
    last.weights.row(i) *= share;
    last.bias(i) = share * last.bias(i) + (1.0 - share) * (rows(i, 0) - map.output_mean(i)) / scale;
    map.skip.row(i) = share * map.skip.row(i) + (1.0 - share) / scale * rows.row(i).segment(1, columns);
  }
  if (shares.isZero(0.0) && !keep_hidden && map.layers.size() > 1) {
    map.layers = {codegen::DenseLayer{map.skip, last.bias}};
    map.skip.resize(0, 0);
    map.largest_activations.clear();
  }
}

}  // namespace nlo::trainer
