// SPDX-License-Identifier: MIT
#include "trainer/learn/training/tune_constants.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "trainer/base/coordinate_search.h"
#include "trainer/rollout/rollout.h"
#include "trainer/rollout/sampling.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/make_dynamics.h"
#include "trainer/structures/moments.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

using Eigen::VectorXd;

/// Returns whole runs, spread over the data.
std::vector<Segment> some_whole_runs(const TrainingData& data) {
  constexpr std::ptrdiff_t kMostSamples = 1 << 17;
  const std::vector<Segment> runs = whole_runs(data);
  std::ptrdiff_t samples = 0;
  for (const Segment& run : runs) samples += run.length;
  const auto every = static_cast<std::size_t>(1 + samples / kMostSamples);
  std::vector<Segment> some;
  for (std::size_t i = 0; i < runs.size(); i += every) {
    some.push_back(runs[i]);
    some.back().length = static_cast<int>(std::min<std::ptrdiff_t>(runs[i].length, kMostSamples));
  }
  return some;
}

/// Returns segments of draws that no step of the training uses; none if the training uses whole runs.
std::vector<Segment> some_segments(const Experiment& experiment, const TrainingData& data) {
  constexpr long kDraws = 4;
  std::vector<Segment> some;
  if (trains_whole_runs(experiment.training)) return some;
  for (long no_step = -kDraws; no_step < 0; ++no_step)
    for (const Segment& segment : draw_segments(experiment, data, no_step)) some.push_back(segment);
  return some;
}

class Tuning {
 public:
  Tuning(const ObserverStructure& structure, const Experiment& experiment, const TrainingData& data, ThreadPool& pool)
      : structure_(structure),
        experiment_(experiment),
        data_(data),
        pool_(pool),
        runs_(some_whole_runs(data)),
        segments_(some_segments(experiment, data)),
        inverse_variance_(VectorXd::Ones(data.nx)) {
    for (int i = 0; i < data.nx && experiment.loss.is_normalised(); ++i) {
      Moments moments;
      for (const TrainingData::Run& run : data.runs)
        for (int k = 0; k < run.samples; ++k)
          moments.add(
              static_cast<double>(run.states[static_cast<std::size_t>(i) * static_cast<std::size_t>(run.samples) +
                                             static_cast<std::size_t>(k)]),
              static_cast<double>(run.weight[static_cast<std::size_t>(k)]));
      const auto deviation = static_cast<double>(safe_scale(moments.deviation()));
      inverse_variance_(i) = 1.0 / (deviation * deviation);
    }
  }

  /// Returns the structure with its constants multiplied by 10^log10.
  ObserverStructure with(const VectorXd& log10) const {
    ObserverStructure changed = structure_;
    structure_.module->multiply_constants(changed, Eigen::pow(10.0, log10.array()).matrix());
    return changed;
  }

  /// Returns the cost of tune_constants.h, or NaN if an estimate is not finite.
  double cost(const VectorXd& log10) const {
    const ObserverStructure tried = with(log10);
    const auto dynamics = make_dynamics(experiment_, tried, data_.steps_s, pool_.threads());
    dynamics->prepare(initial_dynamics(tried, experiment_).data());
    const double of_runs = rmse(tried, *dynamics, runs_);
    return segments_.empty() ? of_runs : std::sqrt(of_runs * rmse(tried, *dynamics, segments_));
  }

 private:
  /// Returns the RMSE of the estimates, or NaN if one is not finite.
  double rmse(const ObserverStructure& tried, LatentDynamics& dynamics, const std::vector<Segment>& segments) const {
    Rollout rollout(data_);
    rollout.run(segments, dynamics, experiment_.training.all_noise(), experiment_.seed, Purpose::kValidationNoise, 0,
                pool_, experiment_.training.input_noise);
    double squares = 0.0, total = 0.0;
    for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
      const auto w = static_cast<double>(weight(rollout, segment, time));
      if (w == 0.0) return;
      total += w;
      for (int i = 0; i < data_.nx; ++i) {
        const int row = tried.module->estimate_row(tried, i);
        const auto error = static_cast<double>(group.latent[group.at(row, time) + static_cast<std::size_t>(lane)] -
                                               rollout.state(segment, static_cast<std::size_t>(i), time));
        squares += w * error * error * inverse_variance_(i);
      }
    });
    return std::sqrt(squares / total);
  }

  const ObserverStructure& structure_;
  const Experiment& experiment_;
  const TrainingData& data_;
  ThreadPool& pool_;
  std::vector<Segment> runs_, segments_;
  VectorXd inverse_variance_;  ///< n_x, weights of the squared errors
};

}  // namespace

void tune_constants(ObserverStructure& structure, const Experiment& experiment, const TrainingData& data,
                    ThreadPool& pool) {
  const int constants = structure.module->tuned_constants(structure);
  if (constants == 0) return;
  const Tuning tuning(structure, experiment, data, pool);
  const CostsOf costs = [&](const std::vector<VectorXd>& points) {
    std::vector<double> result;
    for (const VectorXd& point : points) result.push_back(tuning.cost(point));
    return result;
  };
  std::vector<VectorXd> starts;
  for (const double decades : {0.0, 2.0, 4.0}) {
    starts.emplace_back(VectorXd::Zero(constants));
    starts.back()(0) = decades;
  }
  const std::vector<double> found = costs(starts);
  std::size_t best = 0;
  for (std::size_t i = 1; i < starts.size(); ++i)
    if (found[i] < found[best] || !std::isfinite(found[best])) best = i;
  const Tuned tuned = coordinate_search(starts[best], costs);
  if (std::isfinite(tuned.cost)) structure = tuning.with(tuned.x);
}

}  // namespace nlo::trainer
