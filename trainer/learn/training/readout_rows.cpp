// SPDX-License-Identifier: MIT
#include "trainer/learn/training/readout_rows.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
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

namespace {

constexpr double kStrengths[] = {1e-6, 1e-4, 1e-2};

/// Adds ridge regressions on the first `columns` of `u`, see fit_rows().
void add_ridges(Index columns, const MatrixXd& u, const RowInputs& inputs, const SampledTruth& training,
                double settled_from, std::vector<RowCandidate>& result) {
  const auto add = [&](const auto& ridge) {
    for (const double strength : kStrengths) {
      MatrixXd rows = MatrixXd::Zero(training.x.rows(), 1 + inputs.all());
      rows.leftCols(1 + columns) = ridge.fit(strength);
      result.push_back({std::move(rows), columns > inputs.features()});
    }
  };
  if (inputs.has_clocks()) {
    TransientRidge ridge;
    ridge.add(u.topRows(columns), training.x, training.weights, training.since_start);
    return add(ridge);
  }
  const WindowWeights split = split_weights(training, settled_from);
  for (const VectorXd& weights : {training.weights, split.has_both() ? split.settled : training.weights}) {
    Ridge ridge;
    ridge.add(u.topRows(columns), training.x, weights);
    add(ridge);
  }
}

/// Sets RowCandidate::distance, which stays empty if there is no T*.
void measure_distances(const codegen::Model& model, const MatrixXd& u, const SampledTruth& training,
                       std::vector<RowCandidate>& all) {
  if (codegen::inverse_map(model) == nullptr) return;
  const MatrixXd map = codegen::ReferenceObserver<float>(model).estimates(training.z, training.y);
  for (RowCandidate& candidate : all) {
    candidate.distance = VectorXd::Zero(model.nx());
    const MatrixXd squares = (map - candidate.rows * with_one(u)).cwiseAbs2();
    for (Index i = 0; i < model.nx(); ++i)
      if (model.states[static_cast<std::size_t>(i)].wrap == 0.0)
        candidate.distance(i) = std::sqrt(weighted_mean(squares.row(i), training.weights));
  }
}

/// Errors of all candidates that may estimate one state, and the state's truth, on N samples.
struct CandidateErrors {
  Eigen::RowVectorXd map, truth;
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<double> distances;                            ///< RowCandidate::distance of each row
  std::vector<std::optional<Eigen::RowVectorXd>> readings;  ///< errors of the outputs in the state's unit
};

/// Returns the mean square error of a T* that falls back to row `c`, for each reach. The distance between T* and the
/// row is the difference of their errors.
std::array<double, kReaches.size()> squares_with_fallback(const CandidateErrors& errors, std::size_t c,
                                                          const VectorXd& weights) {
  std::array<double, kReaches.size()> squares{};
  squares.fill(std::numeric_limits<double>::infinity());
  if (!(errors.distances[c] > 0.0)) return squares;
  const Eigen::ArrayXXd row = errors.rows[c], distance = errors.map.array() - row;
  for (std::size_t r = 0; r < kReaches.size(); ++r) {
    const double reach = kReaches[r] * errors.distances[c];
    squares[r] = weighted_mean((row + distance / (1.0 + (distance / reach).square())).square().matrix(), weights);
  }
  return squares;
}

StateSquares squares_in(const CandidateErrors& errors, const VectorXd& weights) {
  StateSquares squares;
  squares.map = weighted_mean(errors.map.cwiseAbs2(), weights);
  for (std::size_t c = 0; c < errors.rows.size(); ++c) {
    const Eigen::RowVectorXd& row = errors.rows[c];
    squares.row.push_back(weighted_mean(row.cwiseAbs2(), weights));
    squares.both.push_back(weighted_mean(row.cwiseProduct(errors.map), weights));
    squares.fallback.push_back(squares_with_fallback(errors, c, weights));
  }
  for (const auto& reading : errors.readings)
    squares.reading.push_back(reading ? weighted_mean(reading->cwiseAbs2(), weights)
                                      : std::numeric_limits<double>::infinity());
  squares.deviation = weighted_variance(errors.truth, weights);
  return squares;
}

std::vector<RowCandidate> row_candidates(const codegen::Model& model, const RowInputs& inputs,
                                         const SampledTruth& training, double settled_from, bool with_distances) {
  const MatrixXd u = inputs.values(training);
  std::vector<RowCandidate> result;
  add_ridges(inputs.features(), u, inputs, training, settled_from, result);
  MatrixXd constant = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  constant.col(0) = training.x * training.weights / training.weights.sum();
  result.push_back({.rows = std::move(constant), .is_constant = true});
  if (!inputs.readings().empty()) add_ridges(inputs.all(), u, inputs, training, settled_from, result);
  for (std::size_t j = 0; j < inputs.readings().size(); ++j) {
    const MatrixXd rows = inputs.reading_alone(j).transpose().replicate(model.nx(), 1);
    result.push_back({rows, true});
  }
  if (with_distances) measure_distances(model, u, training, result);
  return result;
}

}  // namespace

std::optional<FittedRows> fit_rows(const codegen::Model& model, const Rollout& training, double settled_from,
                                   bool with_distances) {
  SampledTruth fitted = sample_truth(model, training, kReadoutSamples);
  if (fitted.weights.size() == 0) return std::nullopt;
  RowInputs inputs(model, fitted);
  std::vector<RowCandidate> candidates = row_candidates(model, inputs, fitted, settled_from, with_distances);
  return FittedRows{std::move(fitted), std::move(inputs), std::move(candidates), settled_from};
}

JudgedSet squares_of(const codegen::Model& model, const FittedRows& rows, const SampledTruth& samples) {
  const codegen::ReferenceObserver<float> observer(model);
  const MatrixXd of_map = errors_of(observer.estimates(samples.z, samples.y), samples.x, model.states);
  const MatrixXd u = with_one(rows.inputs.values(samples));
  const WindowWeights split = split_weights(samples, rows.settled_from);
  JudgedSet result;
  if (split.has_both()) result.windows.resize(2);
  for (Index i = 0; i < model.nx(); ++i) {
    const codegen::Channel& state = model.states[static_cast<std::size_t>(i)];
    CandidateErrors errors{of_map.row(i), samples.x.row(i), {}, {}, {}};
    const auto errors_in = [&](const Eigen::RowVectorXd& estimate) -> Eigen::RowVectorXd {
      return errors_of(estimate, errors.truth, {state});
    };
    for (const RowCandidate& candidate : rows.candidates) {
      errors.rows.push_back(errors_in(candidate.rows.row(i) * u));
      errors.distances.push_back(candidate.distance.size() > 0 ? candidate.distance(i) : 0.0);
    }
    for (int j = 0; j < model.ny(); ++j) {
      const bool measures = j < model.measured() && model.outputs[static_cast<std::size_t>(j)].unit == state.unit;
      errors.readings.push_back(measures ? std::optional(errors_in(samples.y.row(j))) : std::nullopt);
    }
    result.all.push_back(squares_in(errors, samples.weights));
    if (!split.has_both()) continue;
    result.windows[0].push_back(squares_in(errors, split.transient));
    result.windows[1].push_back(squares_in(errors, split.settled));
  }
  if (!split.has_both()) result.windows = {result.all};
  return result;
}

JudgedSet squares_on(const codegen::Model& model, const FittedRows& rows, const Rollout& judged) {
  const SampledTruth samples = sample_truth(model, judged, kReadoutSamples);
  return samples.weights.size() == 0 ? JudgedSet{} : squares_of(model, rows, samples);
}

namespace {

/// Returns the fallback of the states with a reach > 0. Each falls back to its row, on the first `columns` inputs.
codegen::Fallback fallback_to(const MatrixXd& rows, const VectorXd& reach, Index columns) {
  codegen::Fallback fallback;
  for (Index i = 0; i < reach.size(); ++i)
    if (reach(i) > 0.0) fallback.outputs.push_back(static_cast<int>(i));
  fallback.rows = rows(fallback.outputs, Eigen::seqN(1, columns));
  fallback.offset = rows(fallback.outputs, 0);
  fallback.reach = reach(fallback.outputs);
  return fallback;
}

}  // namespace

void write_readout(codegen::Network& map, const RowInputs& inputs, const VectorXd& shares, const VectorXd& reach,
                   const MatrixXd& rows, bool reads_more, bool keep_hidden) {
  if (reads_more) inputs.extend(map);
  const Index columns = map.features.rows();
  if ((reach.array() > 0.0).any()) map.fallback = fallback_to(rows, reach, columns);
  if ((shares.array() == 1.0).all()) return;
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
