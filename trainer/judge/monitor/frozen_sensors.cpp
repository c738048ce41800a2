// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/frozen_sensors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

#include "codegen/replay/reference_monitor.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// kFrozenShare: at most this share of the training samples exceeds the limit of equal readings of an output that may
// fail. At rest, a reference sensor may be outside of its range for at most this share of the samples. kLeastReference:
// smallest share of the other samples at which it must be outside.
constexpr double kFrozenShare = 0.03, kLeastReference = 0.5;
// Smallest limit of equal readings, because a sensor of high resolution sometimes repeats a reading even if no log
// shows it.
constexpr std::size_t kFewestEqual = 5;
// Resting reading of a sensor that is never at rest: no reading equals it.
constexpr double kNoRest = 1e30;

/// Returns the most frequent repeated reading of output j.
double resting_reading(const SensedRuns& runs, Index j) {
  std::map<double, std::size_t> repeated;
  for (const MatrixXd& y : runs.outputs)
    for (Index k = 1; k < y.cols(); ++k)
      if (y(j, k) == y(j, k - 1)) ++repeated[y(j, k)];
  const auto most = std::max_element(repeated.begin(), repeated.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == repeated.end() ? 0.0 : most->first;
}

/// The range of output i while output j is at rest, without the kFrozenShare outermost samples, and the share of the
/// other samples that are outside of it.
struct ReferenceSensor {
  Index output = 0;
  double min = 0.0, max = 0.0, beyond = 0.0;
};
ReferenceSensor reference_sensor_of(const SensedRuns& runs, Index j, double resting, Index i) {
  std::vector<double> at_rest, moving;
  for (const MatrixXd& y : runs.outputs)
    for (Index k = 1; k < y.cols(); ++k) {
      if (!std::isfinite(y(i, k)) || !std::isfinite(y(j, k))) continue;
      if (y(j, k) != resting)
        moving.push_back(y(i, k));
      else if (y(j, k - 1) == resting)
        at_rest.push_back(y(i, k));
    }
  if (at_rest.empty() || moving.empty()) return {i};
  std::sort(at_rest.begin(), at_rest.end());
  const auto out = static_cast<std::size_t>(0.5 * kFrozenShare * static_cast<double>(at_rest.size() - 1));
  ReferenceSensor reference_sensor{i, at_rest[out], at_rest[at_rest.size() - 1 - out]};
  const auto beyond = std::count_if(moving.begin(), moving.end(),
                                    [&](double y) { return y < reference_sensor.min || y > reference_sensor.max; });
  reference_sensor.beyond = static_cast<double>(beyond) / static_cast<double>(moving.size());
  return reference_sensor;
}

/// Returns the number of equal readings in a row (counted like in the monitor) at which output j is frozen: at most
/// kFrozenShare of all samples reach this number.
double most_equal_of(const Monitor& monitor, const SensedRuns& runs, Index j) {
  std::vector<double> samples;  // [i]: number of samples that repeat their reading for the (i + 1)th time
  double all = 0.0;
  for (const MatrixXd& y : runs.outputs) {
    codegen::Repeats repeats;
    for (Index k = 0; k < y.cols(); ++k) {
      if (!std::isfinite(y(j, k))) continue;
      repeats.add(monitor, j, y(j, k), y(static_cast<Index>(monitor.reference_sensor(j)), k), 0.0);
      const auto equal = static_cast<std::size_t>(repeats.equal());
      all += 1.0;
      if (equal == 0) continue;
      samples.resize(std::max(samples.size(), equal));
      samples[equal - 1] += 1.0;
    }
  }
  std::size_t length = samples.size();
  double beyond = 0.0;
  while (length > 0 && (beyond += samples[length - 1]) <= kFrozenShare * all) --length;
  return std::min(static_cast<double>(std::max(length + 1, kFewestEqual)), 65535.0);
}

/// Largest values for one output over all runs after the observer has settled: the number of equal readings in a row,
/// and the change that was predicted during equal readings [deviations].
struct Repeated {
  int longest = 0;
  double moved = 0.0;
};
std::vector<Repeated> repeated(const Monitor& monitor, const SensedRuns& runs, const codegen::Model& model) {
  std::vector<Repeated> all(static_cast<std::size_t>(model.measured()));
  const ObserverRun observer = observer_run(model, runs.uniform());
  const Index armed = codegen::armed_after(monitor, model.sample_period_s);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const MatrixXd& y = runs.outputs[i];
    const VectorXd time =
        runs.uniform() ? VectorXd::LinSpaced(y.cols(), 0.0, static_cast<double>(y.cols() - 1) * model.sample_period_s)
                       : runs.time_s[i];
    const MatrixXd features = codegen::monitor_features(model, observer(y, runs.inputs[i], time));
    const MatrixXd predicted = monitor.deviation.cwiseInverse().asDiagonal() *
                               MatrixXd((monitor.prediction * features).colwise() + monitor.offset);
    for (Index j = 0; j < model.measured(); ++j) {
      codegen::Repeats repeats;
      Repeated& own = all[static_cast<std::size_t>(j)];
      for (Index k = 1; k < y.cols(); ++k) {
        if (!std::isfinite(y(j, k))) continue;
        repeats.add(monitor, j, y(j, k), std::nan(""), k > armed ? predicted(j, k - 1) : 0.0);
        own.longest = std::max(own.longest, repeats.equal());
        own.moved = std::max(own.moved, std::abs(repeats.moved()));
      }
    }
  }
  return all;
}

}  // namespace

void fit_frozen(Monitor& monitor, const SensedRuns& runs, bool simulated, const codegen::Model& model) {
  codegen::leave_out_frozen(monitor, model.ny());
  if (runs.outputs.empty()) return;
  const std::vector<Repeated> all = repeated(monitor, runs, model);
  // A sensor of high resolution repeats a reading only by chance.
  constexpr int kByChance = 3;
  constexpr double kMargin = 2.0, kLeastMoved = 3.0;  // deviations
  for (Index j = 0; j < model.measured(); ++j) {
    const Repeated& own = all[static_cast<std::size_t>(j)];
    monitor.most_moved(j) = std::max(kMargin * own.moved, kLeastMoved);
    if (!simulated && own.longest <= kByChance) {
      monitor.most_equal(j) = std::max<double>(4 * (own.longest + 1), kFewestEqual);
      monitor.resting(j) = monitor.rest_min(j) = monitor.rest_max(j) = kNoRest;
      monitor.reference_sensor(j) = static_cast<double>(j);
    }
  }
  for (const int j : model.failures.outputs) {
    if (simulated || j >= model.measured()) continue;
    const double resting = resting_reading(runs, j);
    // If the reference sensor is the output itself, the output is never considered frozen at rest.
    ReferenceSensor best{j, resting, resting, kLeastReference};
    for (Index i = 0; i < model.measured(); ++i) {
      if (i == j) continue;
      if (const ReferenceSensor other = reference_sensor_of(runs, j, resting, i); other.beyond > best.beyond)
        best = other;
    }
    monitor.resting(j) = resting;
    monitor.reference_sensor(j) = static_cast<double>(best.output);
    monitor.rest_min(j) = best.min;
    monitor.rest_max(j) = best.max;
    monitor.most_equal(j) = most_equal_of(monitor, runs, j);
  }
}

}  // namespace nlo::trainer
