// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/sample_rows.h"

#include <algorithm>

namespace nlo::trainer {
namespace {

std::vector<float> rows(std::size_t count) {
  return std::vector<float>(count * kRow);
}

}  // namespace

SampleRows::SampleRows(const ObserverStructure& structure)
    : x_(rows(structure.state_scale.size())),
      z_(rows(structure.latent_scale.size())),
      y_(rows(static_cast<std::size_t>(structure.readings))),
      f_(x_),
      h_(y_),
      weight_(rows(1)) {}

MapSamples<float> SampleRows::view(int count) const {
  return {.count = count,
          .x = x_.data(),
          .z = z_.data(),
          .y = y_.data(),
          .f = f_.data(),
          .h = h_.data(),
          .weight = weight_.data()};
}

MapSamples<float> SampleRows::gather(const Rollout& rollout, const SampleRange& range, float share,
                                     bool with_equations) {
  const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(range.group)];
  const TrainingData& data = rollout.data();
  const int* offsets = range.offsets();
  const std::size_t nx = x_.size() / kRow, nz = z_.size() / kRow, ny = y_.size() / kRow;
  for (int s = 0; s < range.count; ++s) {
    const auto at = static_cast<std::size_t>(s);
    const int time = offsets[s] / kGroup, lane = offsets[s] % kGroup;
    const Segment& segment = rollout.segment(range.group, lane);
    const TrainingData::Run& run = data.runs[static_cast<std::size_t>(segment.run)];
    const auto k = static_cast<std::size_t>(segment.start + time);
    const auto state_sign = [&](std::size_t row) { return segment.mirrored ? data.mirror.of_state(row) : 1.0F; };
    const auto reading_sign = [&](std::size_t row) { return segment.mirrored ? data.mirror.of_reading(row) : 1.0F; };
    weight_[at] = share * range.weights()[s];
    for (std::size_t i = 0; i < nx; ++i) {
      x_[i * kRow + at] = rollout.state(segment, i, time);
      if (with_equations)
        f_[i * kRow + at] = state_sign(i) * run.derivatives[i * static_cast<std::size_t>(run.samples) + k];
    }
    for (std::size_t r = 0; r < nz; ++r)
      z_[r * kRow + at] = group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)];
    for (std::size_t j = 0; j < ny; ++j) {
      y_[j * kRow + at] = group.readings[group.at(static_cast<int>(j), time) + static_cast<std::size_t>(lane)];
      if (j < static_cast<std::size_t>(data.given()))
        h_[j * kRow + at] = reading_sign(j) * run.readings[j * static_cast<std::size_t>(run.samples) + k];
    }
  }
  return view(range.count);
}

MapSamples<float> SampleRows::gather(const TrainingData::Points& points, int first, int count, float weight) {
  const auto all = static_cast<std::size_t>(points.count), begin = static_cast<std::size_t>(first);
  const auto copy = [&](const std::vector<float>& from, std::vector<float>& to) {
    for (std::size_t row = 0; row < from.size() / all; ++row)
      std::copy_n(from.data() + row * all + begin, count, to.data() + row * kRow);
  };
  copy(points.x, x_);
  copy(points.f, f_);
  copy(points.h, h_);
  std::fill_n(weight_.data(), count, weight);
  return view(count);
}

void SampleRows::scatter(const std::vector<float>& cotangent, const SampleRange& samples, Rollout& rollout) {
  SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(samples.group)];
  for (std::size_t r = 0; r < cotangent.size() / kRow; ++r) {
    float* g = group.cotangent.data() + group.at(static_cast<int>(r), 0);
    for (int s = 0; s < samples.count; ++s)
      g[samples.offsets()[s]] += cotangent[r * kRow + static_cast<std::size_t>(s)];
  }
}

}  // namespace nlo::trainer
