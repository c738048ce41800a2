// SPDX-License-Identifier: MIT
#include "trainer/uncertainty/error_samples.h"

#include <algorithm>
#include <cmath>

#include "codegen/model/domain.h"
#include "codegen/replay/reference_observer.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Place {
  int group, lane, time;
  float weight;
};

/// All samples at which an estimate is asked for and its truth counts, segment by segment.
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

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  if (a.size() == 0) return b;
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

}  // namespace

void ErrorSamples::append(const ErrorSamples& more) {
  hidden = joined(hidden, more.hidden);
  errors = joined(errors, more.errors);
  weights = joined(weights.transpose(), more.weights.transpose()).transpose();
  known.insert(known.end(), more.known.begin(), more.known.end());
}

ErrorSamples error_samples(const codegen::Model& model, const Rollout& rollout, Index count) {
  const std::vector<Place> all = places_of(rollout);
  const auto total = static_cast<Index>(all.size());
  const Index size = std::min(count, total);
  MatrixXd z(model.nz(), size), y(model.nr(), size), x(model.nx(), size);
  ErrorSamples samples;
  samples.weights.resize(size);
  for (Index k = 0; k < size; ++k) {
    // A step that is no whole number meets every phase of a run, whatever the runs' common length is.
    const Place& place = all[static_cast<std::size_t>(k * total / size)];
    const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(place.group)];
    const auto at = [&](const std::vector<float>& signal, Index row) {
      return static_cast<double>(
          signal[group.at(static_cast<int>(row), place.time) + static_cast<std::size_t>(place.lane)]);
    };
    for (Index r = 0; r < z.rows(); ++r) z(r, k) = at(group.latent, r);
    for (Index j = 0; j < y.rows(); ++j) y(j, k) = at(group.readings, j);
    const Segment& segment = rollout.segment(place.group, place.lane);
    for (Index i = 0; i < x.rows(); ++i)
      x(i, k) = static_cast<double>(rollout.state(segment, static_cast<std::size_t>(i), place.time));
    samples.weights(k) = static_cast<double>(place.weight);
  }
  const codegen::ReferenceObserver<float> observer(model);
  samples.hidden = observer.last_hidden(z, y);
  samples.errors = observer.estimates(z, y) - x;
  for (Index i = 0; i < x.rows(); ++i) {
    const double wrap = model.states[static_cast<std::size_t>(i)].wrap;
    if (wrap <= 0.0) continue;
    for (double& error : samples.errors.row(i)) error -= wrap * std::round(error / wrap);
  }
  const codegen::LatentDomain domain(model);
  for (Index k = 0; k < size; ++k) samples.known.push_back(domain.contains(z.col(k), y.col(k)));
  return samples;
}

}  // namespace nlo::trainer
