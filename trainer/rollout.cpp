// SPDX-License-Identifier: MIT
#include "trainer/rollout.h"

#include <algorithm>

namespace nlo::trainer {

TrainingData::TrainingData(const Dataset& dataset)
    : sample_period_s(dataset.sample_period_s),
      uniform(dataset.uniform),
      nx(static_cast<int>(dataset.states.size())),
      ny(static_cast<int>(dataset.outputs.size())) {
  if (uniform) steps_s.push_back(dataset.sample_period_s);
  const auto row_major = [](const Eigen::MatrixXd& m) {
    std::vector<float> out(static_cast<std::size_t>(m.size()));
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out.data(), m.rows(), m.cols()) =
        m.cast<float>();
    return out;
  };
  collocation = {static_cast<int>(dataset.collocation.x.cols()), row_major(dataset.collocation.x),
                 row_major(dataset.collocation.f), row_major(dataset.collocation.h)};
  for (const Trajectory& trajectory : dataset.trajectories) {
    Run run;
    run.samples = static_cast<int>(trajectory.samples());
    run.first_estimate = static_cast<int>(trajectory.first_estimate);
    run.outputs = row_major(trajectory.outputs);
    run.states = row_major(trajectory.states);
    run.derivatives = row_major(trajectory.derivatives);
    run.weight.assign(static_cast<std::size_t>(run.samples), 1.0F);
    for (int k = 0; k < trajectory.weight.size(); ++k) {
      run.weight[static_cast<std::size_t>(k)] = static_cast<float>(trajectory.weight(k));
    }
    if (!uniform) {
      run.first_step = static_cast<int>(steps_s.size());
      for (int k = 0; k + 1 < run.samples; ++k) steps_s.push_back(trajectory.time_s(k + 1) - trajectory.time_s(k));
      steps_s.push_back(dataset.sample_period_s);
    }
    runs.push_back(std::move(run));
  }
}

std::vector<Segment> whole_runs(const TrainingData& data) {
  std::vector<Segment> segments;
  for (std::size_t r = 0; r < data.runs.size(); ++r) {
    segments.push_back({.run = static_cast<int>(r), .start = 0, .length = data.runs[r].samples});
  }
  return segments;
}

void Rollout::run(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseConfig& noise,
                  std::uint64_t seed, Purpose purpose, std::uint64_t step, ThreadPool& pool) {
  segments_ = segments;
  groups_.resize((segments.size() + kGroup - 1) / kGroup);
  pool.run(static_cast<int>(groups_.size()), [&](int index, int thread) {
    gather(index, noise, stream_seed(seed, purpose, step, static_cast<std::uint64_t>(index)));
    SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
    group.latent.resize(group.at(dynamics.rows(), 0));
    dynamics.forward(group, thread);
  });
}

void Rollout::gather(int index, const NoiseConfig& noise, std::uint64_t stream) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const int first = index * kGroup;
  group.lanes = std::min(kGroup, static_cast<int>(segments_.size()) - first);
  group.length = 0;
  for (int l = 0; l < group.lanes; ++l) group.length = std::max(group.length, segment(index, l).length);
  group.outputs.resize(group.at(data_->ny, 0));
  group.step_of.assign(data_->uniform ? 0 : group.at(1, 0), 0);
  float level[kGroup], sign[kGroup];
  int start[kGroup], last[kGroup];
  const TrainingData::Run* runs[kGroup];
  for (int l = 0; l < kGroup; ++l) {
    const Segment& segment = this->segment(index, std::min(l, group.lanes - 1));
    runs[l] = &data_->runs[static_cast<std::size_t>(segment.run)];
    level[l] = segment.noise_level * static_cast<float>(noise.scale);
    sign[l] = segment.sign;
    last[l] = segment.length - 1;  // past its end a segment repeats its last sample
    start[l] = segment.start;
  }
  for (int j = 0; j < data_->ny; ++j) {
    const float* from[kGroup];
    for (int l = 0; l < kGroup; ++l) from[l] = runs[l]->outputs.data() + j * runs[l]->samples + start[l];
    float* to = group.outputs.data() + group.at(j, 0);
    for (int t = 0; t < group.length; ++t, to += kGroup) {
      for (int l = 0; l < kGroup; ++l) to[l] = sign[l] * from[l][std::min(t, last[l])];
    }
  }
  for (int t = 0; !data_->uniform && t < group.length; ++t) {
    int* to = group.step_of.data() + group.at(0, t);
    for (int l = 0; l < kGroup; ++l) to[l] = runs[l]->first_step + start[l] + std::min(t, last[l]);
  }
  if (noise.kind == NoiseKind::kNone) return;
  RandomLanes random(stream);
  const std::size_t count = group.outputs.size();
  float* y = group.outputs.data();
  float draw[2][kGroup];
  for (std::size_t at = 0; at < count; at += 2 * kGroup) {
    if (noise.kind == NoiseKind::kGaussian) {
      random.normal_pair(draw[0], draw[1]);
    } else {
      for (auto& lane : draw) {
        random.uniform(lane);
        for (float& u : lane) u = 2.0F * u - 1.0F;
      }
    }
    for (std::size_t half = 0; half < 2 && at + half * kGroup < count; ++half) {
      for (std::size_t l = 0; l < kGroup; ++l) y[at + half * kGroup + l] += level[l] * draw[half][l];
    }
  }
}

}  // namespace nlo::trainer
