// SPDX-License-Identifier: MIT
#include "trainer/rollout/rollout.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace nlo::trainer {
namespace {

/// Two numbers per lane: normal, or uniform in [-1, 1).
void draw_pair(RandomLanes& random, NoiseKind kind, float (&draw)[2][kGroup]) {
  if (kind == NoiseKind::kGaussian) return random.normal_pair(draw[0], draw[1]);
  for (auto& lane : draw) {
    random.uniform(lane);
    for (float& u : lane) u = 2.0F * u - 1.0F;
  }
}

/// Noise on an angle that is given by its sine and cosine turns the two.
void turn(float& sine, float& cosine, float angle) {
  const float s = std::sin(angle), c = std::cos(angle), before = sine;
  sine = before * c + cosine * s;
  cosine = cosine * c - before * s;
}

/// Numbers the distinct steps. A grain of 1/16384 of the period misplaces y by at most 1/32768 of what it moves in a
/// sample, below any sensor's resolution; and the errors do not add up, since the latent system forgets.
class DistinctSteps {
 public:
  DistinctSteps(double period_s, std::vector<double>& steps_s) : grain_s_(period_s / 16384.0), steps_s_(steps_s) {}

  int index_of(double step_s) {
    const long long grains = std::max(1LL, std::llround(step_s / grain_s_));
    const auto [found, is_new] = index_.try_emplace(grains, static_cast<int>(steps_s_.size()));
    if (is_new) steps_s_.push_back(static_cast<double>(grains) * grain_s_);
    return found->second;
  }

 private:
  double grain_s_;
  std::vector<double>& steps_s_;
  std::unordered_map<long long, int> index_;
};

}  // namespace

TrainingData::TrainingData(const Dataset& dataset, const codegen::SensorFailures& sensor_failures)
    : sample_period_s(dataset.sample_period_s),
      uniform(dataset.uniform),
      nx(static_cast<int>(dataset.states.size())),
      ny(static_cast<int>(dataset.outputs.size())),
      nr(static_cast<int>(dataset.readings().size() + sensor_failures.outputs.size())),
      failures(sensor_failures),
      output_angles(dataset.output_angles) {
  for (std::size_t j = 0; j < dataset.outputs.size(); ++j)
    reading_mirror.push_back(static_cast<float>(dataset.mirror.output(j)));
  for (int i = 0; i < given() - ny; ++i)
    reading_mirror.push_back(static_cast<float>(dataset.mirror.input(static_cast<std::size_t>(i))));
  reading_mirror.resize(static_cast<std::size_t>(nr), 1.0F);
  for (std::size_t i = 0; i < dataset.states.size(); ++i)
    state_mirror.push_back(static_cast<float>(dataset.mirror.state(i)));
  if (uniform) steps_s.push_back(dataset.sample_period_s);
  DistinctSteps distinct(sample_period_s, steps_s);
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
    run.readings = row_major(trajectory.outputs);
    if (given() > ny) {
      const std::vector<float> inputs = row_major(trajectory.inputs);
      run.readings.insert(run.readings.end(), inputs.begin(), inputs.end());
    }
    run.states = row_major(trajectory.states);
    run.derivatives = row_major(trajectory.derivatives);
    run.weight.assign(static_cast<std::size_t>(run.samples), 1.0F);
    for (int k = 0; k < trajectory.weight.size(); ++k) {
      run.weight[static_cast<std::size_t>(k)] = static_cast<float>(trajectory.weight(k));
    }
    if (!uniform) {
      for (int k = 0; k + 1 < run.samples; ++k)
        run.step_of.push_back(distinct.index_of(trajectory.time_s(k + 1) - trajectory.time_s(k)));
      run.step_of.push_back(distinct.index_of(sample_period_s));
    }
    runs.push_back(std::move(run));
  }
  for (const double step_s : steps_s) fading.push_back(static_cast<float>(std::exp(-step_s / failures.staleness_s)));
}

std::vector<Segment> whole_runs(const TrainingData& data) {
  std::vector<Segment> segments;
  for (std::size_t r = 0; r < data.runs.size(); ++r) {
    segments.push_back({.run = static_cast<int>(r), .start = 0, .length = data.runs[r].samples});
  }
  return segments;
}

std::vector<Segment> runs_with_failures(const TrainingData& data) {
  std::vector<Segment> segments;
  for (std::size_t i = 0; i < data.failures.outputs.size(); ++i) {
    for (Segment run : whole_runs(data)) {
      run.outages.resize(data.failures.outputs.size());
      run.outages[i] = {0, run.length};
      segments.push_back(std::move(run));
    }
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
  group.readings.resize(group.at(data_->nr, 0));
  group.step_of.assign(data_->uniform ? 0 : group.at(1, 0), 0);
  float level[kGroup];
  bool mirrored[kGroup];
  int start[kGroup], last[kGroup];
  const TrainingData::Run* runs[kGroup];
  for (int l = 0; l < kGroup; ++l) {
    const Segment& segment = this->segment(index, std::min(l, group.lanes - 1));
    runs[l] = &data_->runs[static_cast<std::size_t>(segment.run)];
    level[l] = segment.noise_level;
    mirrored[l] = segment.mirrored;
    last[l] = segment.length - 1;  // past its end a segment repeats its last sample
    start[l] = segment.start;
  }
  for (int j = 0; j < data_->given(); ++j) {
    const float* from[kGroup];
    float sign[kGroup];
    for (int l = 0; l < kGroup; ++l) {
      from[l] = runs[l]->readings.data() + j * runs[l]->samples + start[l];
      sign[l] = mirrored[l] ? data_->reading_mirror[static_cast<std::size_t>(j)] : 1.0F;
    }
    float* to = group.readings.data() + group.at(j, 0);
    for (int t = 0; t < group.length; ++t, to += kGroup) {
      for (int l = 0; l < kGroup; ++l) to[l] = sign[l] * from[l][std::min(t, last[l])];
    }
  }
  for (int t = 0; !data_->uniform && t < group.length; ++t) {
    int* to = group.step_of.data() + group.at(0, t);
    for (int l = 0; l < kGroup; ++l)
      to[l] = runs[l]->step_of[static_cast<std::size_t>(start[l] + std::min(t, last[l]))];
  }
  add_noise(group, noise, level, stream);
  if (!data_->failures.none()) add_outages(index);
}

/// As nlo/sensor_failures.h: a missing output fades to where it rests, and its staleness rises.
void Rollout::add_outages(int index) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const codegen::SensorFailures& failures = data_->failures;
  for (std::size_t i = 0; i < failures.outputs.size(); ++i) {
    float* y = group.readings.data() + group.at(failures.outputs[i], 0);
    float* stale = group.readings.data() + group.at(data_->given() + static_cast<int>(i), 0);
    const auto rest = static_cast<float>(failures.rest(static_cast<Eigen::Index>(i)));
    for (int l = 0; l < kGroup; ++l) {
      const std::vector<Outage>& outages = segment(index, std::min(l, group.lanes - 1)).outages;
      const Outage outage = outages.empty() ? Outage{} : outages[i];
      float last_y = 0.0F, last_stale = 0.0F;
      for (int t = 0; t < group.length; ++t) {
        const int at = t * kGroup + l, before = at - kGroup;
        const std::size_t step = group.step_of.empty() || t == 0
                                     ? 0
                                     : static_cast<std::size_t>(group.step_of[static_cast<std::size_t>(before)]);
        const float keep = t == 0 ? 0.0F : data_->fading[step];
        const bool missing = t >= outage.from && t < outage.to;
        if (missing) y[at] = rest + keep * (last_y - rest);
        stale[at] = missing ? 1.0F - keep * (1.0F - last_stale) : keep * last_stale;
        last_y = y[at];
        last_stale = stale[at];
      }
    }
  }
}

/// `level`: of each lane, times the configured noise.
void Rollout::add_noise(SegmentGroup& group, const NoiseConfig& noise, const float* level, std::uint64_t stream) const {
  RandomLanes random(stream);
  float draw[2][kGroup];
  int left = 0;  // of `draw`: normal numbers come in pairs
  NoiseKind kind = NoiseKind::kNone;
  auto angle = data_->output_angles.begin();
  std::size_t sensor = 0;
  for (int row = 0; row < data_->ny; ++sensor) {
    const bool encoded = angle != data_->output_angles.end() && angle->sine == row;
    const SensorNoise& own = noise.of(sensor);
    if (own.kind != kind) left = 0;
    kind = own.kind;
    float scale[kGroup];
    for (int l = 0; l < kGroup; ++l) {
      scale[l] = level[l] * static_cast<float>(own.scale);
      if (encoded) scale[l] *= static_cast<float>(2.0 * std::numbers::pi / angle->wrap);
    }
    float* y = group.readings.data() + group.at(row, 0);
    float* cosine = encoded ? group.readings.data() + group.at(row + 1, 0) : nullptr;
    for (int t = 0; kind != NoiseKind::kNone && t < group.length; ++t, y += kGroup) {
      if (left == 0) {
        draw_pair(random, kind, draw);
        left = 2;
      }
      const float* v = draw[2 - left--];
      if (!encoded) {
        for (int l = 0; l < kGroup; ++l) y[l] += scale[l] * v[l];
        continue;
      }
      for (int l = 0; l < kGroup; ++l) turn(y[l], cosine[l], scale[l] * v[l]);
      cosine += kGroup;
    }
    row += encoded ? 2 : 1;
    if (encoded) ++angle;
  }
}

}  // namespace nlo::trainer
