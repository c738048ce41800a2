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

/// The values of some rows of a run, rows x samples.
using Rows = std::vector<float>;

/// Moments and range of one row of a signal.
struct Range {
  Moments moments;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    moments.add(value, 1.0);
    low = std::min(low, value);
    high = std::max(high, value);
  }
};
/// Returns the ranges of the first rows of a signal. signal(i): its values in run i.
template <class Signal>
std::vector<Range> ranges_of(const TrainingData& data, int rows, const Signal& signal) {
  std::vector<Range> ranges(static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const auto samples = static_cast<std::size_t>(data.runs[i].samples);
    const Rows& values = signal(i);
    for (std::size_t row = 0; row < ranges.size(); ++row)
      for (std::size_t k = 0; k < samples; ++k) ranges[row].add(static_cast<double>(values[row * samples + k]));
  }
  return ranges;
}

/// Steps x by the equations from sample k of a run to the next one. Returns the length of the step [s].
double step_on(const PriorSetting& own, const TrainingData& data, const TrainingData::Run& run, int k, double* x) {
  const std::size_t step = run.step_of.empty() ? 0 : static_cast<std::size_t>(run.step_of[static_cast<std::size_t>(k)]);
  own.equations.step(x, data.steps_s[step], [&](double c, double* u) {
    for (int j = 0; j < own.inputs; ++j) {
      const float* const input = run.readings.data() + static_cast<std::ptrdiff_t>(own.ny() + j) * run.samples + k;
      const auto to = static_cast<double>(input[1]), from = own.commands ? to : static_cast<double>(input[0]);
      u[j] = (1.0 - c) * from + c * to;
    }
  });
  return data.steps_s[step];
}

/// Returns the trajectories of the unestimated states in a run. Simulated runs have them. Beside logs, the equations
/// step them along the logged states, from the middle of their box. They stay within ten widths of it, because
/// equations may be unstable.
Rows unestimated_states(const PriorSetting& own, const TrainingData& data, const TrainingData::Run& run) {
  constexpr double kMostWidths = 10.0;
  if (own.unestimated == 0 || !run.unestimated.empty()) return run.unestimated;
  const auto estimated = static_cast<std::size_t>(own.estimated()), samples = static_cast<std::size_t>(run.samples);
  Rows rows(own.start_box.size() * samples);
  std::vector<double> x(static_cast<std::size_t>(own.carried()));
  for (std::size_t k = 0; k < samples; ++k) {
    for (std::size_t i = 0; i < own.start_box.size(); ++i) {
      const auto [low, high] = own.start_box[i];
      const double middle = 0.5 * (low + high), most = kMostWidths * (high - low);
      double& value = x[estimated + i];
      value = k == 0 || !std::isfinite(value) ? middle : std::clamp(value, middle - most, middle + most);
      rows[i * samples + k] = static_cast<float>(value);
    }
    if (k + 1 == samples) break;
    for (std::size_t i = 0; i < estimated; ++i) x[i] = static_cast<double>(run.states[i * samples + k]);
    (void)step_on(own, data, run, static_cast<int>(k), x.data());
  }
  return rows;
}

/// The states of all runs that the equations step.
class States {
 public:
  States(const PriorSetting& own, const TrainingData& data)
      : own_(own), data_(data), logged_(own.unestimated > 0 && data.runs.front().unestimated.empty()) {
    for (const TrainingData::Run& run : data.runs) unestimated_.push_back(unestimated_states(own, data, run));
    ranges_ = ranges_of(data, own.estimated(), [&data](std::size_t i) -> const Rows& { return data.runs[i].states; });
    std::vector<Range> more =
        ranges_of(data, own.unestimated, [this](std::size_t i) -> const Rows& { return unestimated_[i]; });
    for (std::size_t i = 0; logged_ && i < more.size(); ++i) {
      const Range box = of_box(i);
      if (box.moments.deviation() > more[i].moments.deviation()) more[i].moments = box.moments;
      more[i].low = std::min(more[i].low, box.low);
      more[i].high = std::max(more[i].high, box.high);
    }
    std::ranges::copy(more, std::back_inserter(ranges_));
  }

  const std::vector<Range>& ranges() const { return ranges_; }

  /// Returns state i at sample k of a run. Unestimated states follow the estimated ones.
  double at(std::size_t run, std::size_t i, int k) const {
    const auto estimated = static_cast<std::size_t>(own_.estimated());
    const std::size_t place = static_cast<std::size_t>(data_.runs[run].samples) * (i < estimated ? i : i - estimated);
    return static_cast<double>(
        (i < estimated ? data_.runs[run].states : unestimated_[run])[place + static_cast<std::size_t>(k)]);
  }

  /// Returns mean and variance of each state at the start of segments (prior_start.h).
  std::vector<Moments> starts() const {
    constexpr std::size_t kEnough = 16;  // runs
    std::vector<Moments> starts;
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      if (is_unknown(i)) {
        starts.push_back(of_box(i - static_cast<std::size_t>(own_.estimated())).moments);
        continue;
      }
      starts.push_back(ranges_[i].moments);
      if (!own_.whole_runs || data_.runs.size() < kEnough) continue;
      starts[i] = {};
      for (std::size_t run = 0; run < data_.runs.size(); ++run) starts[i].add(at(run, i, 0), 1.0);
    }
    return starts;
  }

  /// Returns true for a state that no run has.
  bool is_unknown(std::size_t i) const { return logged_ && i >= static_cast<std::size_t>(own_.estimated()); }

 private:
  Range of_box(std::size_t i) const {
    Range range;
    range.add(own_.start_box[i].low);
    range.add(own_.start_box[i].high);
    return range;
  }

  const PriorSetting& own_;
  const TrainingData& data_;
  bool logged_;
  std::vector<Rows> unestimated_;
  std::vector<Range> ranges_;
};

/// Mean squares of the residuals of the equations, for each state and each output.
struct LeftOver {
  std::vector<double> states, outputs;
};
LeftOver left_over(const PriorSetting& own, const TrainingData& data, const States& known) {
  const auto nx = static_cast<std::size_t>(own.nx()), ny = static_cast<std::size_t>(own.ny());
  std::vector<Moments> states(nx), outputs(ny);
  const auto add = [](Moments& to, double error) {
    if (std::isfinite(error)) to.add(error * error, 1.0);
  };
  constexpr std::ptrdiff_t kEnough = 50000;  // samples
  std::ptrdiff_t all = 0, sample = 0;
  for (const TrainingData::Run& run : data.runs) all += run.samples;
  const std::ptrdiff_t every = 1 + all / kEnough;
  for (std::size_t of = 0; of < data.runs.size(); ++of) {
    const TrainingData::Run& run = data.runs[of];
    const auto reading = [&run](std::size_t row, int k) {
      return static_cast<double>(
          run.readings[row * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(k)]);
    };
    for (int k = 0; k < run.samples; ++k) {
      if (sample++ % every != 0 || run.weight[static_cast<std::size_t>(k)] == 0.0F) continue;
      std::vector<double> x(static_cast<std::size_t>(own.carried())), y(ny * (1 + nx)), u;
      for (std::size_t i = 0; i < nx; ++i) x[i] = known.at(of, i, k);
      for (std::size_t j = 0; j < static_cast<std::size_t>(own.inputs); ++j) u.push_back(reading(ny + j, k));
      own.equations.output(x.data(), u.data(), y.data());
      for (std::size_t j = 0; j < ny; ++j) add(outputs[j], reading(j, k) - y[j]);
      if (k + 1 >= run.samples || run.weight[static_cast<std::size_t>(k) + 1] == 0.0F) continue;
      const double step_s = step_on(own, data, run, k, x.data());
      const double share = std::sqrt(own.period_s / step_s);  // the variance grows with the step
      for (std::size_t i = 0; i < nx; ++i) add(states[i], share * (known.at(of, i, k + 1) - x[i]));
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
  const std::vector<Range> readings =
      ranges_of(data, data.given(), [&data](std::size_t i) -> const Rows& { return data.runs[i].readings; });
  const States known(own, data);
  const std::vector<Range>& states = known.ranges();
  const std::vector<Moments> starts = known.starts();
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
  const LeftOver left = left_over(own, data, known);
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    own.scale.push_back(kDrift * deviations[i]);
    const double variance = deviations[i] * deviations[i];
    own.state_noise.push_back(own.noisy || known.is_unknown(i) ? kStateOfNoisy * variance
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
