// SPDX-License-Identifier: MIT
#include "trainer/learn/training/readout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "codegen/base/error.h"
#include "trainer/data/log_baselines.h"
#include "trainer/learn/training/readout_rows.h"
#include "trainer/rollout/sampled_truth.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kSamples = 150000;
/// Of a squared error: what is this near to the best counts as the best, and the simpler of the two is taken.
constexpr double kAlike = 1.02;

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

/// What a value of each set counts as, together.
using Together = std::function<double(const std::function<double(const StateSquares&)>&)>;

/// The worse of training and validation data.
Together worst_of(const std::vector<const StateSquares*>& sets) {
  return [sets](const auto& value) {
    double worst = 0.0;
    for (const StateSquares* set : sets) worst = std::max(worst, value(*set));
    return worst;
  };
}

/// Of groups that were left out the geometric mean: one log that is unlike all others counts as one. What is less than
/// .1 % of the state's deviation is as good as nothing.
Together typical_of(const std::vector<const StateSquares*>& sets) {
  return [sets](const auto& value) {
    double sum = 0.0;
    for (const StateSquares* set : sets) sum += std::log(std::max(value(*set), 1e-6 * set->deviation + 1e-300));
    return std::exp(sum / static_cast<double>(sets.size()));
  };
}

void find_sensor(const codegen::Model& model, const Together& together, StateReadout& result) {
  std::vector<double> errors;
  for (std::size_t j = 0; j < model.outputs.size(); ++j)
    errors.push_back(std::sqrt(together([j](const StateSquares& s) { return s.reading[j]; })));
  const int best = best_sensor(errors, result.deviation);
  if (best < 0) return;
  result.sensor = errors[static_cast<std::size_t>(best)];
  result.sensor_name = model.outputs[static_cast<std::size_t>(best)].name;
}

}  // namespace

double StateSquares::blend(std::size_t c, double share) const {
  return share * share * map + 2.0 * share * (1.0 - share) * both[c] + (1.0 - share) * (1.0 - share) * row[c];
}

double StateSquares::best_share(std::size_t c) const {
  const double apart = map + row[c] - 2.0 * both[c];  // mean square of the difference of the two estimates
  if (!(apart > 0.0)) return 1.0;
  return std::round(20.0 * std::clamp((row[c] - both[c]) / apart, 0.0, 1.0)) / 20.0;
}

SetSquares left_out_squares(const codegen::Model& model, const Rollout& training, const Rollout& left_out) {
  const SampledTruth fitted = sample_truth(model, training, kSamples), judged = sample_truth(model, left_out, kSamples);
  if (fitted.weights.size() == 0 || judged.weights.size() == 0) return {};
  const RowInputs inputs(model, fitted);
  return squares_of(model, inputs, row_candidates(model, inputs, fitted), judged);
}

Readout choose_readout(codegen::Model& model, const Rollout& flight, const Rollout& validation, bool keep_hidden,
                       const std::vector<SetSquares>& left_out) {
  const SampledTruth training = sample_truth(model, flight, kSamples);
  const SampledTruth judged = sample_truth(model, validation, kSamples);
  if (training.weights.size() == 0 || judged.weights.size() == 0) return {};
  const RowInputs inputs(model, training);
  const std::vector<RowCandidate> all = row_candidates(model, inputs, training);
  const SetSquares on_validation = squares_of(model, inputs, all, judged);
  const std::vector<SetSquares> sets =
      left_out.empty() ? std::vector<SetSquares>{squares_of(model, inputs, all, training), on_validation} : left_out;
  for (const SetSquares& set : sets)
    if (set.front().row.size() != all.size())
      throw codegen::Error("left-out logs: trainings without them have other features");

  codegen::Network* map = codegen::inverse_map(model);
  VectorXd shares = VectorXd::Ones(model.nx());
  MatrixXd rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  bool reads_more = false;
  Readout result;
  for (Index i = 0; i < model.nx(); ++i) {
    const auto state = static_cast<std::size_t>(i);
    std::vector<const StateSquares*> own;
    for (const SetSquares& set : sets) own.push_back(&set[state]);
    const Together together = left_out.empty() ? worst_of(own) : typical_of(own);
    const auto of_row = [&](std::size_t c) { return together([c](const StateSquares& s) { return s.row[c]; }); };
    // The simplest row that is as good as the best.
    double least = of_row(0);
    for (std::size_t c = 1; c < all.size(); ++c) least = std::min(least, of_row(c));
    std::size_t chosen = 0;
    while (chosen + 1 < all.size() && !(of_row(chosen) <= kAlike * least)) ++chosen;

    const auto of_blend = [&](double share) {
      return together([&](const StateSquares& s) { return s.blend(chosen, share); });
    };
    double share = own.back()->best_share(chosen);  // on validation data
    for (int twentieth = 0; !left_out.empty() && twentieth <= 20; ++twentieth)
      if (const double other = twentieth / 20.0; of_blend(other) < of_blend(share)) share = other;
    const double as_row = of_row(chosen), as_map = of_blend(1.0), as_blend = of_blend(share);
    const double good = kAlike * std::min({as_row, as_map, as_blend});
    if (map != nullptr) shares(i) = as_row <= good ? 0.0 : as_map <= good ? 1.0 : share;
    if (shares(i) < 1.0) {
      rows.row(i) = all[chosen].rows.row(i);
      reads_more = reads_more || all[chosen].reads_more;
    }

    StateReadout& told = result.emplace_back(
        StateReadout{.state = model.states[state].name,
                     .share = shares(i),
                     .trained = std::sqrt(as_map),
                     .linear = map != nullptr ? std::sqrt(as_row) : std::numeric_limits<double>::infinity(),
                     .shipped = std::sqrt(shares(i) == 0.0   ? as_row
                                          : shares(i) == 1.0 ? as_map
                                                             : as_blend),
                     .validation = std::sqrt(on_validation[state].blend(chosen, shares(i))),
                     .constant = std::sqrt(of_row(std::size(kRidges))),
                     .deviation = std::sqrt(on_validation[state].deviation)});
    find_sensor(model, together, told);
  }
  if (map != nullptr && (shares.array() < 1.0).any()) write(*map, inputs, shares, rows, reads_more, keep_hidden);
  return result;
}

std::string share_text(double share) {
  return share == 1.0 ? "network" : share == 0.0 ? "linear row" : fmt::format("{:.2f} network", share);
}

std::string readout_fact(const Readout& readout, std::size_t left_out) {
  std::vector<std::pair<std::string, std::string>> groups;  // what is read, states
  for (const StateReadout& state : readout) {
    const std::string text = share_text(state.share);
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == text; });
    if (found == groups.end())
      groups.emplace_back(text, state.state);
    else
      found->second += ", " + state.state;
  }
  const std::string by = left_out == 0 ? "" : fmt::format(" (by {} groups of logs that were left out)", left_out);
  if (groups.size() == 1) return groups.front().first + by;
  std::string text;
  for (const auto& [what, states] : groups) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", what, states);
  return text + by;
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
