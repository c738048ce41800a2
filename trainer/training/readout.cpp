// SPDX-License-Identifier: MIT
#include "trainer/training/readout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/replay/reference_observer.h"
#include "trainer/base/ridge.h"
#include "trainer/rollout/sampled_truth.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kSamples = 150000;
constexpr double kRidges[] = {1e-6, 1e-4, 1e-2};
/// Of a squared error: what is this near to the best counts as the best, and the simpler of the two is taken.
constexpr double kAlike = 1.02;
/// Of a deviation: a sensor this good has no noise.
constexpr double kExact = 1e-5;

/// What a linear row may read: the features of T*, then outputs and inputs as they are.
class RowInputs {
 public:
  RowInputs(const codegen::Model& model, const SampledTruth& training) {
    const codegen::Network* map = codegen::inverse_map(model);
    const Index both = model.nz() + model.nr();
    if (map != nullptr) {
      of_ = map->features;
      mean_ = map->feature_mean;
      scale_ = map->feature_scale;
    } else {
      of_ = MatrixXd::Identity(both, both);
      mean_ = VectorXd::Zero(both);
      scale_ = VectorXd::Ones(both);
    }
    features_ = of_.rows();
    // Where T* saturates, a reading as it is would go on outside of the domain.
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

  Index features() const { return features_; }
  Index all() const { return of_.rows(); }
  const std::vector<int>& readings() const { return readings_; }
  /// The row that reads reading `j` alone, [intercept, columns].
  VectorXd reading_alone(std::size_t index) const {
    VectorXd row = VectorXd::Zero(1 + all());
    const Index at = features_ + static_cast<Index>(index);
    row(0) = mean_(at);
    row(1 + at) = scale_(at);
    return row;
  }

  /// all() x N.
  MatrixXd values(const SampledTruth& samples) const {
    MatrixXd u = of_.leftCols(samples.z.rows()) * samples.z;
    if (of_.cols() > samples.z.rows()) u += of_.rightCols(samples.y.rows()) * samples.y;
    return (u.colwise() - mean_).array().colwise() / scale_.array();
  }

  /// Makes the map read the readings too; no layer listens to them yet.
  void extend(codegen::Network& map) const {
    map.features = of_;
    map.feature_mean = mean_;
    map.feature_scale = scale_;
    MatrixXd& first = map.layers.front().weights;
    first.conservativeResizeLike(MatrixXd::Zero(first.rows(), all()));
    if (map.skip.size() != 0) map.skip.conservativeResizeLike(MatrixXd::Zero(map.skip.rows(), all()));
  }

 private:
  void append(const VectorXd& row, double mean, double deviation) {
    const Index at = of_.rows();
    of_.conservativeResize(at + 1, Eigen::NoChange);
    of_.row(at) = row.transpose();
    mean_.conservativeResize(at + 1);
    scale_.conservativeResize(at + 1);
    mean_(at) = mean;
    scale_(at) = deviation > 1e-12 ? deviation : 1.0;
  }

  MatrixXd of_;
  VectorXd mean_, scale_;
  Index features_ = 0;
  std::vector<int> readings_;
};

/// A linear row for every state, the simpler ones first.
struct Candidate {
  MatrixXd rows;  ///< n_x x (1 + all)
  bool reads_more = false;
};

std::vector<Candidate> candidates(const codegen::Model& model, const RowInputs& inputs, const SampledTruth& training) {
  const MatrixXd u = inputs.values(training);
  std::vector<Candidate> result;
  const auto fit = [&](Index columns) {
    Ridge ridge;
    ridge.add(u.topRows(columns), training.x, training.weights);
    for (const double strength : kRidges) {
      MatrixXd rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
      rows.leftCols(1 + columns) = ridge.fit(strength);
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

double mean_square(const Eigen::RowVectorXd& errors, const VectorXd& weights) {
  return errors.cwiseAbs2().dot(weights.transpose()) / weights.sum();
}

/// The share of a that makes |share a + (1 - share) b|^2 least, in twentieths.
double best_share(const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b, const VectorXd& weights) {
  const Eigen::RowVectorXd d = a - b;
  const double norm = mean_square(d, weights);
  if (!(norm > 0.0)) return 1.0;
  const double share = -(b.cwiseProduct(d)).dot(weights.transpose()) / weights.sum() / norm;
  return std::round(20.0 * std::clamp(share, 0.0, 1.0)) / 20.0;
}

/// T* as chosen: shares of its last layer, and the rows beside it.
void write(codegen::Network& map, const RowInputs& inputs, const VectorXd& shares, const MatrixXd& rows,
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

/// Mean squared errors of an estimate.
struct Squares {
  double training = 0.0, validation = 0.0;
  /// A candidate counts as what it is on the harder of both sets. Validation logs alone may be easier than what was
  /// trained on, and then a row wins there that loses wherever it is harder.
  double worse() const { return std::max(training, validation); }
};

/// The data that judge an estimate.
class Judges {
 public:
  Judges(const codegen::Model& model, const RowInputs& inputs, const SampledTruth& training,
         const SampledTruth& validation)
      : model_(&model), samples_{&training, &validation} {
    const codegen::ReferenceObserver<float> observer(model);
    for (std::size_t s = 0; s < 2; ++s) {
      trained_[s] = errors_of(observer.estimates(samples_[s]->z, samples_[s]->y), samples_[s]->x, model.states);
      u_[s] = with_one(inputs.values(*samples_[s]));
    }
  }

  /// Of w . [1; u; y] for a state.
  Squares row(Index state, const Eigen::RowVectorXd& w) const {
    return squares([&](std::size_t s) { return of_row(s, state, w); });
  }
  Squares map(Index state) const {
    return squares([&](std::size_t s) -> Eigen::RowVectorXd { return trained_[s].row(state); });
  }
  Squares blend(Index state, const Eigen::RowVectorXd& w, double share) const {
    return squares([&](std::size_t s) -> Eigen::RowVectorXd {
      return share * trained_[s].row(state) + (1.0 - share) * of_row(s, state, w);
    });
  }
  Squares reading(Index state, int reading) const {
    return squares([&](std::size_t s) { return errors(s, state, samples_[s]->y.row(reading)); });
  }
  /// The share of T* in the blend that suits validation data best.
  double share(Index state, const Eigen::RowVectorXd& w) const {
    return best_share(trained_[1].row(state), of_row(1, state, w), samples_[1]->weights);
  }
  double deviation(Index state) const {
    const Eigen::RowVectorXd truth = samples_[1]->x.row(state);
    const double mean = truth.dot(samples_[1]->weights.transpose()) / samples_[1]->weights.sum();
    return std::sqrt(mean_square(truth.array() - mean, samples_[1]->weights));
  }

 private:
  template <class Errors>
  Squares squares(const Errors& errors) const {
    return {mean_square(errors(0), samples_[0]->weights), mean_square(errors(1), samples_[1]->weights)};
  }
  Eigen::RowVectorXd errors(std::size_t s, Index state, const Eigen::RowVectorXd& estimate) const {
    return errors_of(estimate, samples_[s]->x.row(state), {model_->states[static_cast<std::size_t>(state)]});
  }
  Eigen::RowVectorXd of_row(std::size_t s, Index state, const Eigen::RowVectorXd& w) const {
    return errors(s, state, w * u_[s]);
  }

  const codegen::Model* model_;
  const SampledTruth* samples_[2];
  MatrixXd trained_[2], u_[2];
};

void find_sensor(const codegen::Model& model, const Judges& judges, Index state, StateReadout& result) {
  for (int j = 0; j < model.ny(); ++j) {
    const codegen::Channel& output = model.outputs[static_cast<std::size_t>(j)];
    if (output.unit != model.states[static_cast<std::size_t>(state)].unit) continue;
    const double error = std::sqrt(judges.reading(state, j).worse());
    // A sensor without any noise is a simulated one: it says nothing of the real one.
    if (error <= kExact * result.deviation || error >= result.sensor) continue;
    result.sensor = error;
    result.sensor_name = output.name;
  }
}

}  // namespace

Readout choose_readout(codegen::Model& model, const Rollout& flight, const Rollout& validation, bool keep_hidden) {
  const SampledTruth training = sample_truth(model, flight, kSamples);
  const SampledTruth judged = sample_truth(model, validation, kSamples);
  if (training.weights.size() == 0 || judged.weights.size() == 0) return {};
  const RowInputs inputs(model, training);
  const std::vector<Candidate> all = candidates(model, inputs, training);
  const Judges judges(model, inputs, training, judged);

  codegen::Network* map = codegen::inverse_map(model);
  VectorXd shares = VectorXd::Ones(model.nx());
  MatrixXd rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  bool reads_more = false;
  Readout result;
  for (Index i = 0; i < model.nx(); ++i) {
    // The simplest row that is as good as the best.
    std::vector<double> squares;
    for (const Candidate& candidate : all) squares.push_back(judges.row(i, candidate.rows.row(i)).worse());
    const double least = *std::min_element(squares.begin(), squares.end());
    const auto chosen = static_cast<std::size_t>(
        std::find_if(squares.begin(), squares.end(), [&](double s) { return s <= kAlike * least; }) - squares.begin());
    const Candidate& candidate = all[std::min(chosen, all.size() - 1)];
    const Eigen::RowVectorXd row = candidate.rows.row(i);

    const double share = judges.share(i, row);
    const Squares of_row = judges.row(i, row), of_map = judges.map(i), of_blend = judges.blend(i, row, share);
    const double good = kAlike * std::min({of_row.worse(), of_map.worse(), of_blend.worse()});
    if (map != nullptr) shares(i) = of_row.worse() <= good ? 0.0 : of_map.worse() <= good ? 1.0 : share;
    const Squares& shipped = shares(i) == 0.0 ? of_row : shares(i) == 1.0 ? of_map : of_blend;
    if (shares(i) < 1.0) {
      rows.row(i) = row;
      reads_more = reads_more || candidate.reads_more;
    }

    StateReadout state{.state = model.states[static_cast<std::size_t>(i)].name,
                       .share = shares(i),
                       .trained = std::sqrt(of_map.worse()),
                       .linear = map != nullptr ? std::sqrt(of_row.worse()) : std::numeric_limits<double>::infinity(),
                       .shipped = std::sqrt(shipped.worse()),
                       .validation = std::sqrt(shipped.validation),
                       .constant = std::sqrt(judges.row(i, all[std::size(kRidges)].rows.row(i)).worse()),
                       .deviation = judges.deviation(i)};
    find_sensor(model, judges, i, state);
    result.push_back(std::move(state));
  }
  if (map != nullptr && (shares.array() < 1.0).any()) write(*map, inputs, shares, rows, reads_more, keep_hidden);
  return result;
}

std::string share_text(double share) {
  return share == 1.0 ? "network" : share == 0.0 ? "linear row" : fmt::format("{:.2f} network", share);
}

std::string readout_fact(const Readout& readout) {
  std::vector<std::pair<std::string, std::string>> groups;  // what is read, states
  for (const StateReadout& state : readout) {
    const std::string text = share_text(state.share);
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == text; });
    if (found == groups.end())
      groups.emplace_back(text, state.state);
    else
      found->second += ", " + state.state;
  }
  if (groups.size() == 1) return groups.front().first;
  std::string text;
  for (const auto& [what, states] : groups) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", what, states);
  return text;
}

std::string below_floor(const Readout& readout) {
  constexpr double kWorse = 1.05, kOfDeviation = 0.005;
  std::string text;
  for (const StateReadout& s : readout) {
    struct Simple {
      double error;
      std::string name;
    };
    const Simple simple = std::min({Simple{s.linear, "a linear row of what T* reads"}, Simple{s.constant, "its mean"},
                                    Simple{s.sensor, "output " + s.sensor_name + " as it is"}},
                                   [](const Simple& a, const Simple& b) { return a.error < b.error; });
    if (s.shipped <= kWorse * simple.error || s.shipped - simple.error <= kOfDeviation * s.deviation) continue;
    text += fmt::format("{}{} has an RMSE of {:.3g}, {} has {:.3g}", text.empty() ? "" : "; ", s.state, s.shipped,
                        simple.name, simple.error);
  }
  if (text.empty()) return text;
  return "the observer is worse than the simple thing: " + text +
         ". The model is kept. Let T* read the output ([observer] features = \"latent_and_output\"), spread the "
         "eigenvalues about the plant's own time constants, or train for more steps";
}

}  // namespace nlo::trainer
