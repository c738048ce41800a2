// SPDX-License-Identifier: MIT
#include "trainer/learn/training/no_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "trainer/base/number_text.h"
#include "trainer/structures/for_each_sample.h"

namespace nlo::trainer {

namespace {

/// If most values of a feature are this much smaller than its extremes, a network sees almost no change of the feature,
/// and the extremes disturb it.
constexpr double kFarBeyondScale = 50.0;

std::string name_of(const ObserverStructure& structure, const std::vector<Channel>& readings, const Feature& feature) {
  const auto clock = [&](int row) {
    return fmt::format("the clock of {:.3g} s", -1.0 / structure.eigenvalues[static_cast<std::size_t>(row)]);
  };
  if (feature.without >= 0)
    return fmt::format("{} times {}",
                       name_of(structure, readings, structure.features[static_cast<std::size_t>(feature.without)]),
                       clock(feature.clock));
  if (is_clock(structure, feature)) return clock(feature.latent);
  const std::string reading = feature.reading < 0 ? "" : readings[static_cast<std::size_t>(feature.reading)].name;
  const bool is_input = feature.reading >= structure.outputs();
  if (feature.latent < 0) return fmt::format("the {} {}", is_input ? "input" : "output", reading);
  return fmt::format("the latent row {}{}", feature.latent + 1, reading.empty() ? "" : " less " + reading);
}

/// Describes the channel whose mean is furthest from 0, if it is more than one deviation. The means of an odd plant are
/// near 0.
std::optional<std::string> off_centre(const Dataset& dataset) {
  std::string furthest;
  double most = 1.0;  // a mean within one deviation is no evidence, because a few runs need not be balanced
  const auto look_at = [&](const std::vector<Channel>& channels, Eigen::MatrixXd Trajectory::*signal,
                           const std::vector<bool>& odd, std::size_t first) {
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (!odd[first + i]) continue;
      double count = 0.0, sum = 0.0, squares = 0.0;
      for (const Trajectory& run : dataset.trajectories) {
        for (Eigen::Index k = 0; k < run.samples(); ++k) {
          if (run.weight(k) <= 0.0) continue;
          const double value = (run.*signal)(static_cast<Eigen::Index>(i), k);
          count += 1.0;
          sum += value;
          squares += value * value;
        }
      }
      const double mean = sum / count, deviation = std::sqrt(std::max(0.0, squares / count - mean * mean));
      if (std::abs(mean) <= most * deviation || channels[i].wrap > 0.0) continue;
      most = std::abs(mean) / std::max(deviation, 1e-300);
      furthest = fmt::format("the mean of {} is {:.3g}, {:.2g} deviations from zero", channels[i].name, mean, most);
    }
  };
  look_at(dataset.outputs, &Trajectory::outputs, dataset.mirror.readings, 0);
  if (dataset.reads_inputs)
    look_at(dataset.inputs, &Trajectory::inputs, dataset.mirror.readings, dataset.outputs.size());
  look_at(dataset.states, &Trajectory::states, dataset.mirror.states, 0);
  return furthest.empty() ? std::nullopt : std::optional(furthest);
}

bool improved(const std::vector<MetricsRow>& metrics) {
  return std::any_of(metrics.begin() + 1, metrics.end(),
                     [&](const MetricsRow& row) { return row.validation_rmse < metrics.front().validation_rmse; });
}

bool loss_grew(const std::vector<MetricsRow>& metrics) {
  return !metrics.empty() && metrics.back().loss > 2.0 * metrics.front().loss;
}

}  // namespace

bool closed_form_is_best(const std::vector<MetricsRow>& metrics, const ObserverStructure& structure,
                         const Dataset& dataset, const Rollout& flight) {
  if (structure.network.linear_path < 0 || metrics.size() < 2 || improved(metrics) || loss_grew(metrics)) return false;
  if (largest_feature(structure, dataset.readings(), flight).reach > kFarBeyondScale) return false;
  return dataset.mirror.none() || !off_centre(dataset);
}

std::string closed_form_text(const std::vector<MetricsRow>& metrics) {
  return fmt::format(
      "the closed form is best: none of {} training steps improved the ridge regression with which training starts "
      "(its validation error is {:.3g}; now {:.3g}). The ridge regression is the model",
      metrics.back().step, metrics.front().validation_rmse, metrics.back().validation_rmse);
}

std::string no_progress(const std::vector<MetricsRow>& metrics) {
  if (metrics.size() < 2) return "";
  const MetricsRow &first = metrics.front(), &last = metrics.back();
  if (!improved(metrics))
    return fmt::format(
        "training made no progress: none of its {} steps has a lower validation error than the model it "
        "started from ({:.3g}; now {:.3g}), which is the one that was kept",
        last.step, first.validation_rmse, last.validation_rmse);
  // Each loss is from one draw of samples, so several losses must agree.
  constexpr std::size_t kFewest = 3;
  const auto late = std::find_if(metrics.begin(), metrics.end(),
                                 [&](const MetricsRow& row) { return 4 * row.step >= 3 * last.step; });
  if (static_cast<std::size_t>(metrics.end() - late) < kFewest) return "";
  const auto smallest =
      std::min_element(late, metrics.end(), [](const MetricsRow& a, const MetricsRow& b) { return a.loss < b.loss; });
  if (smallest->loss <= first.loss) return "";
  return fmt::format(
      "training went wrong: its loss grew from {:.3g} at the start to {:.3g} and stayed there; the model "
      "of the lowest validation error was kept",
      first.loss, last.loss);
}

LargestFeature largest_feature(const ObserverStructure& structure, const std::vector<Channel>& readings,
                               const Rollout& flight) {
  LargestFeature largest;
  for (const Feature& feature : structure.features) {
    double reach = 0.0;
    for_each_sample(flight, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
      reach = std::max(reach, std::abs(static_cast<double>(normalised_feature(feature, group, lane, time))));
    });
    if (reach > largest.reach) largest = {name_of(structure, readings, feature), reach};
  }
  return largest;
}

std::string likely_causes(const Experiment& experiment, const std::vector<MetricsRow>& metrics,
                          const ObserverStructure& structure, const Dataset& dataset, const Rollout& flight) {
  std::vector<std::string> causes;
  const LargestFeature largest = largest_feature(structure, dataset.readings(), flight);
  const std::string reach =
      largest.name.empty() ? "" : fmt::format("{} reaches {:.3g} times its scale", largest.name, largest.reach);
  if (largest.reach > kFarBeyondScale)
    causes.push_back(
        fmt::format("{}: use eigenvalues nearer to the plant's own, or look for outliers in the outputs", reach));
  if (!dataset.mirror.none())
    if (const auto off = off_centre(dataset))
      causes.push_back(fmt::format(
          "mirror = true says that the plant is odd, but {}: set mirror = false, or declare this channel even", *off));
  constexpr int kFewSteps = 200;
  if (experiment.training.steps < kFewSteps)
    causes.push_back(fmt::format("{} steps may be too few", experiment.training.steps));
  // With too high a rate the loss grows. Then this cause comes before those that only make training slower.
  causes.insert(
      loss_grew(metrics) && largest.reach <= kFarBeyondScale ? causes.begin() : causes.end(),
      fmt::format("learning_rate = {} may be too high: try {}", shortest_text(experiment.training.learning_rate),
                  fmt::format("{:.3g}", experiment.training.learning_rate / 10.0)));
  std::string text = "Likely causes, the most likely one first: ";
  for (std::size_t i = 0; i < causes.size(); ++i) text += (i > 0 ? "; " : "") + causes[i];
  if (largest.reach <= kFarBeyondScale && !reach.empty())
    text += fmt::format(". No feature leaves its scale: {}, the largest value", reach);
  return text + ".";
}

}  // namespace nlo::trainer
