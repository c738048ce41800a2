// SPDX-License-Identifier: MIT
#include "trainer/rollout/sampled_truth.h"

#include <algorithm>
#include <cmath>

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

struct Place {
  int group, lane, time;
  float weight;
};

/// Returns all samples at which an estimate is required and the truth counts, segment by segment.
std::vector<Place> places_of(const Rollout& rollout) {
  std::vector<Place> places;
  for (std::size_t g = 0; g < rollout.groups().size(); ++g)
    for (int l = 0; l < rollout.groups()[g].lanes; ++l) {
      const Segment& segment = rollout.segment(static_cast<int>(g), l);
      const TrainingData::Run& run = rollout.data().runs[static_cast<std::size_t>(segment.run)];
      for (int t = std::max(0, run.first_estimate - segment.start); t < segment.length; ++t) {
        const float weight = run.weight[static_cast<std::size_t>(segment.start + t)];
        if (weight > 0.0F) places.push_back({static_cast<int>(g), l, t, weight});
      }
    }
  return places;
}

}  // namespace

SampledTruth sample_truth(const codegen::Model& model, const Rollout& rollout, Index count) {
  const std::vector<Place> all = places_of(rollout);
  const auto total = static_cast<Index>(all.size());
  const Index size = std::min(count, total);
  SampledTruth samples{MatrixXd(model.nz(), size), MatrixXd(model.nr(), size), MatrixXd(model.nx(), size),
                       Eigen::VectorXd(size), std::vector<int>(static_cast<std::size_t>(size))};
  for (Index k = 0; k < size; ++k) {
    // The fractional step varies the position within a run, for any common length of the runs.
    const Place& place = all[static_cast<std::size_t>(k * total / size)];
    const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(place.group)];
    const auto at = [&](const std::vector<float>& signal, Index row) {
      return static_cast<double>(
          signal[group.at(static_cast<int>(row), place.time) + static_cast<std::size_t>(place.lane)]);
    };
    for (Index r = 0; r < samples.z.rows(); ++r) samples.z(r, k) = at(group.latent, r);
    for (Index j = 0; j < samples.y.rows(); ++j) samples.y(j, k) = at(group.readings, j);
    const Segment& segment = rollout.segment(place.group, place.lane);
    for (Index i = 0; i < samples.x.rows(); ++i)
      samples.x(i, k) = static_cast<double>(rollout.state(segment, static_cast<std::size_t>(i), place.time));
    samples.weights(k) = static_cast<double>(place.weight);
    samples.since_start[static_cast<std::size_t>(k)] = place.time;
  }
  return samples;
}

WindowWeights split_weights(const SampledTruth& samples, double from) {
  WindowWeights result{samples.weights, samples.weights};
  for (Index k = 0; k < samples.weights.size(); ++k) {
    const bool is_settled = samples.since_start[static_cast<std::size_t>(k)] >= from;
    (is_settled ? result.transient : result.settled)(k) = 0.0;
  }
  return result;
}

double weighted_mean(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights) {
  return values.dot(weights.transpose()) / weights.sum();
}

double weighted_variance(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights) {
  return weighted_mean((values.array() - weighted_mean(values, weights)).square(), weights);
}

MatrixXd errors_of(const MatrixXd& estimates, const MatrixXd& truth, const std::vector<codegen::Channel>& states) {
  MatrixXd errors = estimates - truth;
  for (Index i = 0; i < errors.rows(); ++i) {
    const double wrap = states[static_cast<std::size_t>(i)].wrap;
    if (wrap <= 0.0) continue;
    for (double& error : errors.row(i)) error -= wrap * std::round(error / wrap);
  }
  return errors;
}

}  // namespace nlo::trainer
