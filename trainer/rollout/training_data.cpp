// SPDX-License-Identifier: MIT
#include "trainer/rollout/training_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "codegen/fold/fold.h"

namespace nlo::trainer {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Numbers the distinct steps. Rounding to 1/16384 of the period changes y by at most 1/32768 of its change in a
/// sample, which is below the resolution of any sensor. The errors do not add up, because the latent system forgets.
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

/// Returns the smallest and the largest value of a reading over all runs.
std::pair<float, float> range_of(const std::vector<TrainingData::Run>& runs, int row) {
  float low = kInfinity, high = -kInfinity;
  for (const TrainingData::Run& run : runs) {
    const float* y = run.readings.data() + static_cast<std::ptrdiff_t>(row) * run.samples;
    for (int k = 0; k < run.samples; ++k) {  // a missing value is NaN, and all its comparisons are false
      if (y[k] < low) low = y[k];
      if (y[k] > high) high = y[k];
    }
  }
  return {low, high};
}

}  // namespace

TrainingData::TrainingData(const Dataset& dataset, const codegen::SensorFailures& sensor_failures)
    : sample_period_s(dataset.sample_period_s),
      uniform(dataset.uniform),
      nx(static_cast<int>(dataset.states.size())),
      ny(static_cast<int>(dataset.outputs.size())),
      nr(static_cast<int>(dataset.readings().size() + sensor_failures.outputs.size())),
      computed(dataset.outputs, dataset.inputs_read()),
      failures(sensor_failures),
      mirror(dataset.mirror) {
  auto angle = dataset.output_angles.begin();
  for (int row = 0; row < given(); row += sensors.back().rows) {
    if (row < ny && is_computed(row)) row = ny;
    if (row == given()) break;
    sensors.push_back({sensors.size(), row});
    if (angle == dataset.output_angles.end() || angle->sine != row) continue;
    sensors.back().rows = 2;
    sensors.back().wrap = (angle++)->wrap;
  }
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
    if (trajectory.missing.size() != 0 && trajectory.missing.any())
      for (int j = 0; j < ny; ++j)
        for (int k = 0; k < run.samples; ++k) run.held.push_back(trajectory.missing(j, k) ? 1 : 0);
    if (trajectory.missing.size() != 0)  // NaN for an output that may fail; others hold their last value
      for (const int row : failures.outputs)
        for (int k = 0; k < run.samples; ++k)
          if (trajectory.missing(row, k))
            run.readings[static_cast<std::size_t>(row) * static_cast<std::size_t>(run.samples) +
                         static_cast<std::size_t>(k)] = std::numeric_limits<float>::quiet_NaN();
    if (given() > ny) {
      const std::vector<float> inputs = row_major(trajectory.inputs);
      run.readings.insert(run.readings.end(), inputs.begin(), inputs.end());
    }
    run.states = row_major(trajectory.states);
    run.unestimated = row_major(trajectory.unestimated);
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
  logged = runs.size();
  if (dataset.simulated_share > 0.0) {
    simulated_share = dataset.simulated_share;
    logged = static_cast<std::size_t>(std::ranges::count_if(
        dataset.trajectories, [](const Trajectory& trajectory) { return !trajectory.log.empty(); }));
  }
  Eigen::VectorXd low(given()), high(given());
  for (int row = 0; row < given(); ++row) std::tie(low(row), high(row)) = range_of(runs, row);
  widen_by_mirror(mirror, low, high);
  for (int row = 0; row < given(); ++row) {
    const bool turns = row < ny && dataset.outputs[static_cast<std::size_t>(row)].wrap > 0.0;
    reading_low.push_back(turns ? -kInfinity : static_cast<float>(low(row)));
    reading_high.push_back(turns ? kInfinity : static_cast<float>(high(row)));
  }
  for (const double step_s : steps_s) {
    const double periods = step_s / sample_period_s;
    fading.push_back(static_cast<float>(std::exp(-step_s / failures.staleness_s)));
    missed.push_back(periods > 1.5 ? static_cast<int>(std::lround(periods)) - 1 : 0);
  }
  const std::vector<int> period = codegen::not_due(dataset.outputs, dataset.inputs_read(), sample_period_s);
  for (const int output : failures.outputs) not_due.push_back(period[static_cast<std::size_t>(output)]);
}

std::vector<Segment> whole_runs(const TrainingData& data) {
  std::vector<Segment> segments;
  for (std::size_t r = 0; r < data.runs.size(); ++r) {
    constexpr int kPieces = 8;  // lanes of a group
    const int samples = data.runs[r].samples, pieces = samples > kLongestWhole ? kPieces : 1;
    const auto start = [&](int piece) { return static_cast<int>(static_cast<long>(samples) * piece / pieces); };
    for (int piece = 0; piece < pieces; ++piece)
      segments.push_back(
          {.run = static_cast<int>(r), .start = start(piece), .length = start(piece + 1) - start(piece)});
  }
  return segments;
}

std::vector<Segment> runs_with_failures(const TrainingData& data, double dropout) {
  std::vector<Segment> segments;
  if (dropout == 0.0) return segments;
  for (std::size_t i = 0; i < data.failures.outputs.size(); ++i) {
    if (data.is_computed(data.failures.outputs[i])) continue;  // a computed output is missing if its source is
    for (Segment run : whole_runs(data)) {
      run.outages.resize(data.failures.outputs.size());
      run.outages[i] = {0, run.length};
      segments.push_back(std::move(run));
    }
  }
  return segments;
}

ReadingLimits::ReadingLimits(const TrainingData& data, const NoiseMixture& noise, const NoiseConfig& input_noise)
    : low(static_cast<std::size_t>(data.given()), -kInfinity), high(low.size(), kInfinity) {
  for (const auto& [sensor, row, rows, wrap] : data.sensors) {
    double widest = -1.0;
    const auto look_at = [&](const SensorNoise& own) {
      if (own.has_tails()) widest = std::max(widest, own.scale);
    };
    if (row < data.ny) {
      for (const NoiseConfig& part : noise.parts) look_at(part.of(sensor));
    } else {
      look_at(input_noise.of(static_cast<std::size_t>(row - data.ny)));
    }
    if (widest < 0.0 || rows > 1) continue;  // noise turns an angle, so its sine and cosine keep their range
    const auto r = static_cast<std::size_t>(row);
    const float range = std::max(data.reading_high[r] - data.reading_low[r], 1e-3F) + static_cast<float>(6.0 * widest);
    low[r] = data.reading_low[r] - range;
    high[r] = data.reading_high[r] + range;
  }
}

}  // namespace nlo::trainer
