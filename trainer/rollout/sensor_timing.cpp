// SPDX-License-Identifier: MIT
// Timing of sensors, applied to the readings of a group of segments: delays, jitter, and then lost samples, before
// noise is added. It has its own random streams, so that other noise does not change.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trainer/base/interpolate.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {
namespace {

enum class Timing : std::uint64_t { kDelay = 1, kClock, kLoss, kStuck, kDead };

Timing stream_of(OutageKind kind) {
  constexpr std::array kStreams = {Timing::kLoss, Timing::kStuck, Timing::kDead};
  return kStreams[static_cast<std::size_t>(kind)];
}

/// Returns the stream of a sensor (for kClock: of all sensors).
RandomLanes timing_lanes(std::uint64_t stream, Timing what, std::size_t sensor) {
  std::uint64_t state = stream ^ 0x74696d65ULL;
  for (const std::uint64_t part : {static_cast<std::uint64_t>(what), static_cast<std::uint64_t>(sensor)})
    state = splitmix64(state) ^ part * 0xd1342543de82ef95ULL;
  return RandomLanes(splitmix64(state));
}

/// Returns one number in [0, 1) for each sample and lane.
std::vector<float> draws_of(RandomLanes random, const SegmentGroup& group) {
  std::vector<float> draws(group.at(1, 0));
  for (int t = 0; t < group.length; ++t) random.uniform(draws.data() + group.at(0, t));
  return draws;
}

}  // namespace

void Rollout::shift_row(int index, int row, const SensorNoise& own, const float* delay, const float* clock) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  float* y = group.readings.data() + group.at(row, 0);
  for (int l = 0; l < kGroup; ++l) {
    const Segment& segment = this->segment(index, std::min(l, group.lanes - 1));
    const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
    const float sign = segment.mirrored ? data_->mirror.of_reading(static_cast<std::size_t>(row)) : 1.0F;
    const float* recorded = run.readings.data() + static_cast<std::ptrdiff_t>(row) * run.samples;
    const auto values = [&](std::ptrdiff_t at) { return sign * recorded[at]; };
    for (int t = 0; t < group.length; ++t) {
      const int at = t * kGroup + l;
      const double position = static_cast<double>(segment.start + std::min(t, segment.length - 1)) -
                              static_cast<double>(delay[l]) + own.jitter * static_cast<double>(clock[at]);
      y[at] = row < data_->ny ? cubic_at<float>(values, run.samples, position)
                              : linear_at<float>(values, run.samples, position);
    }
  }
}

/// Holds samples that do not arrive, as in flight. A missing output that may fail becomes NaN, which fill_missing()
/// replaces.
///   dead  value of the row for a dead sensor
void Rollout::fail_row(int index, int row, OutageKind kind, const OutageRate& rate, const std::vector<float>& draws,
                       float dead) {
  SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  const auto& fails = data_->failures.outputs;
  const bool told = kind == OutageKind::kMissing && std::find(fails.begin(), fails.end(), row) != fails.end();
  const auto failing = static_cast<std::size_t>(std::find(fails.begin(), fails.end(), row) - fails.begin());
  const bool slow = failing < fails.size() && data_->not_due[failing] > 0;  // NaN between its samples
  const OutageOdds odds = outage_odds(rate);
  float* y = group.readings.data() + group.at(row, 0);
  for (int l = 0; l < kGroup; ++l) {
    bool out = false;
    float last = y[l];  // last value that the output has sent
    for (int t = 1; t < group.length; ++t) {
      const int at = t * kGroup + l;
      out = draws[static_cast<std::size_t>(at)] < static_cast<float>(out ? odds.goes_on : odds.begins);
      if (slow && std::isnan(y[at])) continue;
      if (!out) last = y[at];
      if (!out) continue;
      if (kind == OutageKind::kMissing && row < data_->ny) group.hold(data_->ny, row, static_cast<std::size_t>(at));
      const float before = slow ? last : y[at - kGroup];
      y[at] = kind == OutageKind::kDead ? dead : told ? std::numeric_limits<float>::quiet_NaN() : before;
    }
  }
}

void Rollout::measure_late(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream) {
  const SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  std::vector<float> clock = draws_of(timing_lanes(stream, Timing::kClock, 0), group);
  for (float& u : clock) u = 2.0F * u - 1.0F;
  for (const auto& [sensor, row, rows, wrap] : data_->sensors) {
    const SensorNoise& own = noise_of(noise, input_noise, row, sensor);
    if (!own.shifted()) continue;
    float delay[kGroup];
    timing_lanes(stream, Timing::kDelay, sensor).uniform(delay);
    for (float& late : delay)
      late = static_cast<float>(own.delay_low + (own.delay_high - own.delay_low) * static_cast<double>(late));
    for (int r = 0; r < rows; ++r) shift_row(index, row + r, own, delay, clock.data());
  }
}

void Rollout::fail_sensors(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream) {
  const SegmentGroup& group = groups_[static_cast<std::size_t>(index)];
  for (const auto& [sensor, row, rows, wrap] : data_->sensors) {
    const SensorNoise& own = noise_of(noise, input_noise, row, sensor);
    // kMissing comes last, because a stuck sensor may also stop sending.
    for (const OutageKind kind : {OutageKind::kStuck, OutageKind::kDead, OutageKind::kMissing}) {
      const OutageRate& rate = own.outage(kind);
      if (rate.share == 0.0) continue;
      const std::vector<float> draws = draws_of(timing_lanes(stream, stream_of(kind), sensor), group);
      for (int r = 0; r < rows; ++r) fail_row(index, row + r, kind, rate, draws, r == 1 ? 1.0F : 0.0F);  // sine, cosine
    }
  }
}

}  // namespace nlo::trainer
