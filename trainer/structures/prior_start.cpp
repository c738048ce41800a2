// SPDX-License-Identifier: MIT
#include "trainer/structures/prior_start.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "trainer/structures/moments.h"

namespace nlo::trainer {
namespace {

/// Moments and range of one row of a signal.
struct Range {
  Moments moments;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};
std::vector<Range> ranges_of(const TrainingData& data, std::vector<float> TrainingData::Run::*signal, int rows) {
  std::vector<Range> ranges(static_cast<std::size_t>(rows));
  for (const TrainingData::Run& run : data.runs)
    for (std::size_t row = 0; row < ranges.size(); ++row)
      for (int k = 0; k < run.samples; ++k) {
        const auto value = static_cast<double>(
            (run.*signal)[row * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(k)]);
        Range& range = ranges[row];
        range.moments.add(value, 1.0);
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
      }
  return ranges;
}

/// Returns state i of a run at sample k. States that are not estimated follow the estimated ones.
double state_at(const PriorSetting& own, const TrainingData::Run& run, std::size_t i, int k) {
  const auto estimated = static_cast<std::size_t>(own.estimated()), samples = static_cast<std::size_t>(run.samples),
             at = static_cast<std::size_t>(k);
  return static_cast<double>(i < estimated ? run.states[i * samples + at]
                                           : run.unestimated[(i - estimated) * samples + at]);
}

/// Returns mean and variance of each state at the start of segments (prior_start.h).
std::vector<Moments> starts_of(const PriorSetting& own, const TrainingData& data, const std::vector<Range>& states) {
  constexpr std::size_t kEnough = 16;  // runs
  std::vector<Moments> starts;
  for (std::size_t i = 0; i < states.size(); ++i) {
    starts.push_back(states[i].moments);
    if (!own.whole_runs || data.runs.size() < kEnough) continue;
    starts[i] = {};
    for (const TrainingData::Run& run : data.runs) starts[i].add(state_at(own, run, i, 0), 1.0);
  }
  return starts;
}

/// Mean squares of the residuals of the equations, for each state and each output.
struct LeftOver {
  std::vector<double> states, outputs;
};
LeftOver left_over(const PriorSetting& own, const TrainingData& data) {
  const auto nx = static_cast<std::size_t>(own.nx()), ny = static_cast<std::size_t>(own.ny());
  std::vector<Moments> states(nx), outputs(ny);
  const auto add = [](Moments& to, double error) {
    if (std::isfinite(error)) to.add(error * error, 1.0);
  };
  constexpr std::ptrdiff_t kEnough = 50000;  // samples
  std::ptrdiff_t all = 0, sample = 0;
  for (const TrainingData::Run& run : data.runs) all += run.samples;
  const std::ptrdiff_t every = 1 + all / kEnough;
  for (const TrainingData::Run& run : data.runs) {
    const auto at = [&run](const std::vector<float>& signal, std::size_t row, int k) {
      return static_cast<double>(signal[row * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(k)]);
    };
    for (int k = 0; k < run.samples; ++k) {
      if (sample++ % every != 0 || run.weight[static_cast<std::size_t>(k)] == 0.0F) continue;
      std::vector<double> x(static_cast<std::size_t>(own.carried())), y(ny * (1 + nx));
      for (std::size_t i = 0; i < nx; ++i) x[i] = state_at(own, run, i, k);
      own.equations.output(x.data(), y.data());
      for (std::size_t j = 0; j < ny; ++j) add(outputs[j], at(run.readings, j, k) - y[j]);
      if (k + 1 >= run.samples || run.weight[static_cast<std::size_t>(k) + 1] == 0.0F) continue;
      const std::size_t step =
          run.step_of.empty() ? 0 : static_cast<std::size_t>(run.step_of[static_cast<std::size_t>(k)]);
      const double step_s = data.steps_s[step];
      own.equations.step(x.data(), step_s, [&](double c, double* u) {
        for (std::size_t j = 0; j < static_cast<std::size_t>(own.inputs); ++j) {
          const double to = at(run.readings, ny + j, k + 1);
          const double from = own.commands ? to : at(run.readings, ny + j, k);
          u[j] = (1.0 - c) * from + c * to;
        }
      });
      const double share = std::sqrt(own.period_s / step_s);  // the variance grows with the step
      for (std::size_t i = 0; i < nx; ++i) add(states[i], share * (state_at(own, run, i, k + 1) - x[i]));
    }
  }
  LeftOver left;
  for (const Moments& of : states) left.states.push_back(of.mean);
  for (const Moments& of : outputs) left.outputs.push_back(of.mean);
  return left;
}

}  // namespace

void start_prior(PriorSetting& own, const TrainingData& data) {
  // kFine and kCoarse: typical innovations without and with noise, in deviations of a measurement. kGain and kDrift:
  // largest correction of a step, in deviations of the state, so that an optimiser's first steps are small.
  constexpr double kFine = 0.05, kCoarse = 3.0, kGain = 0.3, kDrift = 0.1, kBeyond = 1.0, kCircle = 1.02;
  constexpr double kFineScale = 0.5, kCoarseScale = 0.25;
  // Smallest variances of the noises, and limits of the covariance, relative to the variance of a state or output.
  // kLogarithm: scale of a noise's logarithm.
  constexpr double kStateOfNoisy = 1e-4, kLeastOfState = 1e-8, kLeastOfOutput = 1e-5, kLeast = 1e-10, kMost = 16.0,
                   kLogarithm = 2.0, kLeastOfStart = 0.01;
  own.period_s = data.sample_period_s;
  const int nx = own.nx(), ny = own.ny();
  const std::vector<Range> readings = ranges_of(data, &TrainingData::Run::readings, data.given());
  std::vector<Range> states = ranges_of(data, &TrainingData::Run::states, own.estimated());
  std::ranges::copy(ranges_of(data, &TrainingData::Run::unestimated, own.unestimated), std::back_inserter(states));
  const std::vector<Moments> starts = starts_of(own, data, states);
  const auto scale_of = [](const Range& range) { return static_cast<double>(safe_scale(range.moments.deviation())); };
  Normalisation& read = own.read;
  read.mean.assign(static_cast<std::size_t>(own.reads()), 0.0);
  read.scale.assign(static_cast<std::size_t>(own.reads()), 1.0);
  const auto set = [&read](int row, double mean, double scale) {
    read.mean[static_cast<std::size_t>(row)] = mean;
    read.scale[static_cast<std::size_t>(row)] = scale;
  };
  for (int j = 0; j < ny; ++j) {
    const double deviation = scale_of(readings[static_cast<std::size_t>(j)]);
    own.fine.push_back(kFine * deviation);
    own.coarse.push_back(kCoarse * deviation);
    set(j, 0.0, kFineScale);
    set(ny + j, 0.0, kCoarseScale);
  }
  for (int r = 0; r < data.given(); ++r) {
    const Range& range = readings[static_cast<std::size_t>(r)];
    set(2 * ny + r, range.moments.mean, scale_of(range));
  }
  for (int i = 0; i < nx; ++i) {
    const Range& range = states[static_cast<std::size_t>(i)];
    const double beyond = std::max(kBeyond * (range.high - range.low), 1e-3);
    // Sines and cosines are within [-1, 1]. Wider limits could let a divisor that depends on them become 0.
    const bool on_circle = own.on_circle[static_cast<std::size_t>(i)];
    own.start.push_back(starts[static_cast<std::size_t>(i)].mean);
    own.low.push_back(on_circle ? -kCircle : range.low - beyond);
    own.high.push_back(on_circle ? kCircle : range.high + beyond);
    set(2 * ny + own.readings + i, range.moments.mean, scale_of(range));
    for (int j = 0; j < ny; ++j) own.scale.push_back(kGain * kCoarse * scale_of(range));
  }
  std::vector<double> deviations;
  for (const Range& range : states) deviations.push_back(scale_of(range));
  const LeftOver left = left_over(own, data);
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    own.scale.push_back(kDrift * deviations[i]);
    const double variance = deviations[i] * deviations[i];
    own.state_noise.push_back(own.noisy ? kStateOfNoisy * variance
                                        : std::max(left.states[i], kLeastOfState * variance));
  }
  for (std::size_t j = 0; j < left.outputs.size(); ++j) {
    const double variance = scale_of(readings[j]) * scale_of(readings[j]);
    own.output_noise.push_back(own.noisy ? variance : std::max(left.outputs[j], kLeastOfOutput * variance));
  }
  own.scale.resize(static_cast<std::size_t>(own.corrections()), kLogarithm);
  for (std::size_t i = 0; i < deviations.size(); ++i)
    for (std::size_t j = i; j < deviations.size(); ++j) {
      const double product = deviations[i] * deviations[j];
      const double first = starts[i].deviation();
      own.start.push_back(i == j ? std::max(first * first, kLeastOfStart * product) : 0.0);
      own.low.push_back((i == j ? kLeast : -kMost) * product);
      own.high.push_back(kMost * product);
    }
  // check_bounded() would refuse the trained model, so it is called before the training.
  std::vector<codegen::Interval> x, u;
  for (std::size_t i = 0; i < own.low.size(); ++i) x.emplace_back(own.low[i], own.high[i]);
  for (std::size_t j = 0; j < static_cast<std::size_t>(own.inputs); ++j) {
    const Range& input = readings[static_cast<std::size_t>(ny) + j];
    u.emplace_back(input.low, input.high);
  }
  codegen::check_bounded(own.equations, std::move(x), u, own.period_s);
}

}  // namespace nlo::trainer
