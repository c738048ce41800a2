// SPDX-License-Identifier: MIT
#include "trainer/rollout/rollout.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "codegen/fold/fold.h"
#include "trainer/base/noise_table.h"
#include "trainer/base/sensor_reading.h"

namespace nlo::trainer {
namespace {

/// Random numbers for eight lanes. Uniform and normal numbers are drawn in pairs; the second number of a pair is only
/// used for the same kind.
class LaneNumbers final : public NoiseNumbers<LaneValue> {
 public:
  explicit LaneNumbers(std::uint64_t stream) : random_(stream) {}

  LaneValue uniform() override { return next(Pair::kUniform); }
  LaneValue normal() override { return next(Pair::kNormal); }
  /// Fills the numbers from the last to the first. The results of trained models depend on this order.
  void normals(std::span<LaneValue> all) override {
    for (LaneValue& each : all.subspan(1)) each = normal();
    all[0] = normal();
  }
  /// Draws all numbers of that kind, one after another.
  void draw_series(const NoiseRow& kind, int shape, std::span<LaneValue> all) {
    if (kind.kind == NoiseKind::kGaussian) return normal_series(all);  // fast path, because most noise is Gaussian
    for (LaneValue& each : all) each = kind.draw_lanes(*this, shape);
  }
  /// Returns numbers in [0, 1).
  const float* uniform01() {
    random_.uniform(uniform_);
    return uniform_;
  }

 private:
  void normal_series(std::span<LaneValue> all) {
    static_assert(sizeof(LaneValue) == kGroup * sizeof(float));
    if (pair_ != Pair::kNormal) left_ = 0;
    pair_ = Pair::kNormal;
    if (left_ == 1 && !all.empty()) {
      all[0] = normal();
      all = all.subspan(1);
    }
    const std::size_t pairs = all.size() / 2;
    if (pairs > 0) random_.normal_pairs(all[0].data(), static_cast<int>(pairs));
    if (all.size() % 2 == 1) all.back() = normal();
  }

  enum class Pair { kUniform, kNormal };

  LaneValue next(Pair kind) {
    if (kind != pair_) left_ = 0;
    pair_ = kind;
    if (left_ == 0) {
      draw_pair();
      left_ = 2;
    }
    return draw_[2 - left_--];
  }

  void draw_pair() {
    if (pair_ == Pair::kNormal) return random_.normal_pair(draw_[0].data(), draw_[1].data());
    for (LaneValue& lanes : draw_) {
      random_.uniform(lanes.data());
      lanes = 2.0F * lanes - 1.0F;
    }
  }

  RandomLanes random_;
  LaneValue draw_[2];
  float uniform_[kGroup] = {};
  Pair pair_ = Pair::kNormal;
  int left_ = 0;  ///< unused numbers of draw_
};
static_assert(kGroup == kNoiseLanes);

/// Sets v to the bias, plus an outlier in a random share of the lanes.
void add_outliers(const SensorNoise& own, const float* outlier, LaneNumbers& random, const float* bias, float* v) {
  std::copy_n(bias, kGroup, v);
  float draw[kGroup];
  std::copy_n(random.uniform01(), kGroup, draw);
  const float* u = random.uniform01();
  for (int l = 0; l < kGroup; ++l)
    if (draw[l] < static_cast<float>(own.outlier_share)) v[l] += outlier[l] * (2.0F * u[l] - 1.0F);
}

/// Adds noise to an angle that is given by its sine and cosine.
void turn(float& sine, float& cosine, float angle) {
  const float s = std::sin(angle), c = std::cos(angle), before = sine;
  sine = before * c + cosine * s;
  cosine = cosine * c - before * s;
}

/// Changes the signs of the given readings of a lane to those of its mirror image.
void mirror_lane(const Mirror& mirror, int given, int lane, SegmentGroup& group) {
  for (int row = 0; row < given; ++row) {
    if (!mirror.readings[static_cast<std::size_t>(row)]) continue;
    float* reading = group.readings.data() + group.at(row, 0) + static_cast<std::size_t>(lane);
    for (int t = 0; t < group.length; ++t) reading[t * kGroup] = -reading[t * kGroup];
  }
}

/// Copies the samples [first, first + piece.length) of `rows` rows.
void copy_rows(const SegmentGroup& group, const std::vector<float>& from, int rows, int first,
               const SegmentGroup& piece, std::vector<float>& to) {
  to.resize(piece.at(rows, 0));
  for (int row = 0; row < rows; ++row)
    std::copy_n(from.data() + group.at(row, first), piece.at(1, 0), to.data() + piece.at(row, 0));
}

void roll_out_whole(SegmentGroup& group, LatentDynamics& dynamics, int thread) {
  group.latent.resize(group.at(dynamics.rows(), 0));
  dynamics.forward(group, thread);
}

}  // namespace

void Rollout::run(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseMixture& noise,
                  std::uint64_t seed, Purpose purpose, std::uint64_t step, ThreadPool& pool,
                  const NoiseConfig& input_noise) {
  gather_all(segments, noise, seed, purpose, step, pool, input_noise, [&](int index, int thread) {
    roll_out_whole(groups_[static_cast<std::size_t>(index)], dynamics, thread);
  });
}

void Rollout::run_in_pieces(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseMixture& noise,
                            std::uint64_t seed, Purpose purpose, std::uint64_t step, ThreadPool& pool,
                            const NoiseConfig& input_noise, int length, const VisitPiece& visit) {
  gather_all(segments, noise, seed, purpose, step, pool, input_noise, [&](int index, int thread) {
    SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
    if (!dynamics.continues() || group.length <= length) {
      roll_out_whole(group, dynamics, thread);
      visit(index, 0, group);
      group = SegmentGroup();
      return;
    }
    SegmentGroup piece;
    piece.lanes = group.lanes;
    // A piece begins with the last sample of the previous piece, whose z is known.
    for (int first = 0; first == 0 || first + 1 < group.length; first += length - 1) {
      std::vector<float> last;
      for (int row = 0; first > 0 && row < dynamics.rows(); ++row)
        last.insert(last.end(), piece.latent.data() + piece.at(row, piece.length - 1),
                    piece.latent.data() + piece.at(row, piece.length));
      piece.continues = first > 0;
      piece.length = std::min(length, group.length - first);
      copy_rows(group, group.readings, data_->nr, first, piece, piece.readings);
      if (!group.step_of.empty())
        piece.step_of.assign(group.step_of.data() + group.at(0, first),
                             group.step_of.data() + group.at(0, first + piece.length));
      piece.latent.resize(piece.at(dynamics.rows(), 0));
      for (int row = 0; first > 0 && row < dynamics.rows(); ++row)
        std::copy_n(last.data() + row * kGroup, kGroup, piece.latent.data() + piece.at(row, 0));
      dynamics.forward(piece, thread);
      visit(index, first, piece);
    }
    group = SegmentGroup();
  });
}

void Rollout::gather_all(const std::vector<Segment>& segments, const NoiseMixture& noise, std::uint64_t seed,
                         Purpose purpose, std::uint64_t step, ThreadPool& pool, const NoiseConfig& input_noise,
                         const std::function<void(int index, int thread)>& use) {
  limits_ = ReadingLimits(*data_, noise, input_noise);
  segments_ = segments;
  groups_.resize((segments.size() + kGroup - 1) / kGroup);
  pool.run(static_cast<int>(groups_.size()), [&](int index, int thread) {
    const auto group_index = static_cast<std::uint64_t>(index);
    gather(index, noise.of(step * groups_.size() + group_index), input_noise,
           stream_seed(seed, purpose, step, group_index));
    use(index, thread);
  });
}

void Rollout::gather(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const int first = index * kGroup;
  group.lanes = std::min(kGroup, static_cast<int>(segments_.size()) - first);
  group.length = 0;
  for (int l = 0; l < group.lanes; ++l) group.length = std::max(group.length, segment(index, l).length);
  group.readings.resize(group.at(data_->nr, 0));
  group.step_of.assign(data_->uniform ? 0 : group.at(1, 0), 0);
  float level[kGroup];
  int start[kGroup], last[kGroup];
  const TrainingData::Run* runs[kGroup];
  for (int l = 0; l < kGroup; ++l) {
    const Segment& segment = this->segment(index, std::min(l, group.lanes - 1));
    runs[l] = &data_->runs[static_cast<std::size_t>(segment.run)];
    level[l] = segment.noise_level;
    last[l] = segment.length - 1;  // beyond its end a segment repeats its last sample
    start[l] = segment.start;
  }
  const int all_last = *std::min_element(last, last + kGroup);
  for (int j = 0; j < data_->given(); ++j) {
    const float* from[kGroup];
    for (int l = 0; l < kGroup; ++l) from[l] = runs[l]->readings.data() + j * runs[l]->samples + start[l];
    float* to = group.readings.data() + group.at(j, 0);
    int t = 0;
    for (; t <= all_last; ++t, to += kGroup)
      for (int l = 0; l < kGroup; ++l) to[l] = from[l][t];
    for (; t < group.length; ++t, to += kGroup)
      for (int l = 0; l < kGroup; ++l) to[l] = from[l][std::min(t, last[l])];
  }
  for (int l = 0; l < kGroup; ++l)
    if (segment(index, std::min(l, group.lanes - 1)).mirrored) mirror_lane(data_->mirror, data_->given(), l, group);
  for (int t = 0; !data_->uniform && t < group.length; ++t) {
    int* to = group.step_of.data() + group.at(0, t);
    for (int l = 0; l < kGroup; ++l)
      to[l] = runs[l]->step_of[static_cast<std::size_t>(start[l] + std::min(t, last[l]))];
  }
  if (noise.shifted() || input_noise.shifted()) measure_late(index, noise, input_noise, stream);
  add_noise(group, noise, input_noise, level, stream);
  mark_held(index);
  if (noise.fails() || input_noise.fails()) fail_sensors(index, noise, input_noise, stream);
  clamp(group);
  if (!data_->failures.none()) lose_failing(index);
  compute(group);
  if (!data_->failures.none()) fill_missing(index);
}

/// Clamps readings as in flight (measurement.h).
void Rollout::clamp(SegmentGroup& group) const {
  for (int row = 0; row < data_->given(); ++row) {
    const float low = limits_.low[static_cast<std::size_t>(row)], high = limits_.high[static_cast<std::size_t>(row)];
    if (std::isinf(low)) continue;
    float* y = group.readings.data() + group.at(row, 0);
    for (std::size_t i = 0; i < group.at(1, 0); ++i) y[i] = std::clamp(y[i], low, high);
  }
}

/// Marks the outputs that the runs have not measured, in addition to outages of noise and of sensors that may fail. The
/// first sample of a segment counts as measured, because flight begins with a measurement of each output.
void Rollout::mark_held(int index) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  group.held.clear();
  for (int l = 0; l < kGroup; ++l) {
    const Segment& segment = this->segment(index, std::min(l, group.lanes - 1));
    const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
    if (run.held.empty()) continue;
    for (int j = 0; j < data_->ny; ++j)
      for (int t = 1; t < segment.length; ++t)
        if (run.held[static_cast<std::size_t>(j * run.samples + segment.start + t)] != 0)
          group.hold(data_->ny, j, static_cast<std::size_t>(t * kGroup + l));
  }
}

/// Adds the outages of a segment: NaN while a sensor that may fail is missing.
void Rollout::lose_failing(int index) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const std::vector<int>& failing = data_->failures.outputs;
  for (int l = 0; l < kGroup; ++l) {
    const std::vector<Outage>& outages = segment(index, std::min(l, group.lanes - 1)).outages;
    for (std::size_t i = 0; i < outages.size(); ++i) {
      float* y = group.readings.data() + group.at(failing[i], 0);
      for (int t = outages[i].from; t < std::min(outages[i].to, group.length); ++t)
        y[t * kGroup + l] = std::numeric_limits<float>::quiet_NaN();
    }
  }
}

/// Computes outputs from other readings, as in flight.
void Rollout::compute(SegmentGroup& group) const {
  for (std::size_t i = 0; i < data_->computed.all().size(); ++i) {
    const codegen::Expression& expression = data_->computed.all()[i];
    float* y = group.readings.data() + group.at(data_->computed.first() + static_cast<int>(i), 0);
    for (std::size_t at = 0; at < group.at(1, 0); ++at)
      y[at] = expression.evaluate<float>([&](int row) { return group.readings[group.at(row, 0) + at]; });
  }
}

Rollout::LastArrival Rollout::last_arrival(const Segment& segment, std::size_t failing) const {
  const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
  const auto row = static_cast<std::size_t>(data_->failures.outputs[failing]);
  const float* y = run.readings.data() + row * static_cast<std::size_t>(run.samples);
  const int most = codegen::most_missing(data_->not_due[failing]);
  const float sign = segment.mirrored ? data_->mirror.of_reading(row) : 1.0F;
  const bool out =
      failing < segment.outages.size() && segment.outages[failing].from == 0 && segment.outages[failing].to > 0;
  for (int age = 1; !out && age <= most && age <= segment.start; ++age)
    if (!std::isnan(y[segment.start - age])) return {sign * y[segment.start - age], age - 1};
  return {0.0F, most + 1};  // no sample has arrived yet
}

/// Replaces missing outputs as in nlo/sensor_failures.h: a missing output decays to its mean, and its staleness rises.
/// A slow output holds its last value until it is late.
void Rollout::fill_missing(int index) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const codegen::SensorFailures& failures = data_->failures;
  for (std::size_t i = 0; i < failures.outputs.size(); ++i) {
    float* y = group.readings.data() + group.at(failures.outputs[i], 0);
    float* stale = group.readings.data() + group.at(data_->given() + static_cast<int>(i), 0);
    const auto rest = static_cast<float>(failures.rest(static_cast<Eigen::Index>(i)));
    const int not_due = data_->not_due[i], most = codegen::most_missing(not_due);
    for (int l = 0; l < kGroup; ++l) {
      float last_y = 0.0F, last_stale = 0.0F;
      int age = 0;  // samples since a slow output arrived
      if (not_due > 0) {
        const LastArrival last = last_arrival(segment(index, std::min(l, group.lanes - 1)), i);
        last_y = last.y;
        age = last.age;
      }
      for (int t = 0; t < group.length; ++t) {
        const int at = t * kGroup + l, before = at - kGroup;
        const std::size_t step = group.step_of.empty() || t == 0
                                     ? 0
                                     : static_cast<std::size_t>(group.step_of[static_cast<std::size_t>(before)]);
        const float keep = t == 0 ? 0.0F : data_->fading[step];
        age = std::isnan(y[at]) ? age + 1 + (t == 0 ? 0 : data_->missed[step]) : 0;
        if (not_due > 0 && age > 0 && age <= most) y[at] = last_y;
        const bool missing = std::isnan(y[at]);
        if (age > 0) group.hold(data_->ny, failures.outputs[i], static_cast<std::size_t>(at));
        if (missing) y[at] = rest + keep * (last_y - rest);
        stale[at] = missing ? 1.0F - keep * (1.0F - last_stale) : keep * last_stale;
        last_y = y[at];
        last_stale = stale[at];
      }
    }
  }
}

/// `level`: factor of the configured noise in each lane.
void Rollout::add_noise(SegmentGroup& group, const NoiseConfig& noise, const NoiseConfig& input_noise,
                        const float* level, std::uint64_t stream) const {
  LaneNumbers random(stream);
  for (const auto& [sensor, row, rows, wrap] : data_->sensors) {
    const bool encoded = rows == 2;
    const SensorNoise& own = noise_of(noise, input_noise, row, sensor);
    const NoiseRow& kind = noise_row(own.kind);
    const float unit = encoded ? static_cast<float>(2.0 * std::numbers::pi / wrap) : 1.0F;
    float scale[kGroup], outlier[kGroup], bias[kGroup] = {};
    for (int l = 0; l < kGroup; ++l) {
      scale[l] = level[l] * static_cast<float>(own.scale);
      if (encoded) scale[l] *= unit;
      outlier[l] = level[l] * static_cast<float>(own.outlier_amplitude) * unit;
    }
    if (own.bias > 0.0) {
      const float* u = random.uniform01();
      for (int l = 0; l < kGroup; ++l) bias[l] = level[l] * static_cast<float>(own.bias) * unit * (2.0F * u[l] - 1.0F);
    }
    if (own.common_bias > 0.0) {
      float common[kGroup];  // the same for each sensor, from a separate stream, so that other noise does not change
      RandomLanes(stream ^ 0x636f6d6d6f6eULL).uniform(common);
      for (int l = 0; l < kGroup; ++l)
        bias[l] += level[l] * static_cast<float>(own.common_bias) * unit * (2.0F * common[l] - 1.0F);
    }
    float* y = group.readings.data() + group.at(row, 0);
    float* cosine = encoded ? group.readings.data() + group.at(row + 1, 0) : nullptr;
    std::array<LaneValue, 128> series;
    // With outliers, their numbers and those of the noise are drawn alternately.
    const int together = own.outlier_share > 0.0 ? 1 : static_cast<int>(series.size());
    // v(i) is added to sample t + i.
    using Lanes = simd::Pack<float, kGroup>;
    const auto add = [&](int t, int count, const auto& v) {
      for (int i = 0; i < count; ++i) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(t + i) * kGroup;
        const Lanes lanes = v(i);
        if (!encoded) simd::store(y + at, simd::load<Lanes>(y + at) + lanes);
        for (int l = 0; encoded && l < kGroup; ++l) turn(y[at + l], cosine[at + l], lanes[l]);
      }
    };
    const auto scales = simd::load<Lanes>(scale), biases = simd::load<Lanes>(bias);
    for (int t = 0; own.disturbed() && t < group.length; t += together) {
      const int count = std::min(together, group.length - t);
      if (kind.has_scale()) {
        random.draw_series(kind, own.shape, std::span(series).first(static_cast<std::size_t>(count)));
        add(t, count, [&](int i) { return scales * simd::load<Lanes>(series[static_cast<std::size_t>(i)].data()); });
      }
      if (own.outlier_share > 0.0) {
        float v[kGroup];
        add_outliers(own, outlier, random, bias, v);
        add(t, 1, [&](int) { return simd::load<Lanes>(v); });
      } else if (own.biased()) {
        add(t, count, [&](int) { return biases; });
      }
    }
    if (!clips_or_rounds(own)) continue;
    for (std::size_t i = 0, size = group.at(1, 0); i < size; ++i)
      if (encoded)
        read_angle(own, wrap, y[i], cosine[i]);
      else
        y[i] = reading_of(own, y[i]);
  }
}

}  // namespace nlo::trainer
