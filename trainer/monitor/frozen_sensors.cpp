// SPDX-License-Identifier: MIT
#include "trainer/monitor/frozen_sensors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A sensor that the observer can do without is frozen once it repeats a reading for longer than at all but this share
// of the training's samples. As many of those at rest its witness may be out of its range there; of the others it has
// to be in most.
constexpr double kFrozenShare = 0.03, kLeastWitnessed = 0.5;
// A sensor of high resolution repeats itself now and then, though no log shows it.
constexpr std::size_t kFewestEqual = 5;

/// The reading of output j that is repeated most.
double resting_reading(const SensedRuns& runs, Index j) {
  std::map<double, std::size_t> repeated;
  for (const MatrixXd& y : runs.outputs)
    for (Index k = 1; k < y.cols(); ++k)
      if (y(j, k) == y(j, k - 1)) ++repeated[y(j, k)];
  const auto most = std::max_element(repeated.begin(), repeated.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == repeated.end() ? 0.0 : most->first;
}

/// What output i reads where output j rests, but for kFrozenShare of it, and the share of other samples beyond.
struct Witness {
  Index output = 0;
  double min = 0.0, max = 0.0, beyond = 0.0;
};
Witness witness_of(const SensedRuns& runs, Index j, double resting, Index i) {
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
  Witness witness{i, at_rest[out], at_rest[at_rest.size() - 1 - out]};
  const auto beyond =
      std::count_if(moving.begin(), moving.end(), [&](double y) { return y < witness.min || y > witness.max; });
  witness.beyond = static_cast<double>(beyond) / static_cast<double>(moving.size());
  return witness;
}

/// The most equal readings of output j in a row, as the monitor counts them, but for kFrozenShare of all samples.
double most_equal_of(const Monitor& monitor, const SensedRuns& runs, Index j) {
  std::vector<double> samples;  // [i]: that repeat their reading for the (i + 1)th time
  double all = 0.0;
  for (const MatrixXd& y : runs.outputs) {
    codegen::Repeats repeats;
    for (Index k = 0; k < y.cols(); ++k) {
      if (!std::isfinite(y(j, k))) continue;
      repeats.add(monitor, j, y(j, k), y(static_cast<Index>(monitor.witness(j)), k));
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

}  // namespace

void fit_frozen(Monitor& monitor, const SensedRuns& runs, const codegen::Model& model) {
  monitor.most_equal = monitor.resting = monitor.rest_min = monitor.rest_max = VectorXd::Zero(model.ny());
  monitor.witness = VectorXd::Zero(model.ny());
  for (const int j : model.failures.outputs) {
    if (j >= model.measured() || runs.outputs.empty()) continue;
    const double resting = resting_reading(runs, j);
    Witness best{j, resting, resting, kLeastWitnessed};  // itself: at rest it is never frozen
    for (Index i = 0; i < model.measured(); ++i) {
      if (i == j) continue;
      if (const Witness other = witness_of(runs, j, resting, i); other.beyond > best.beyond) best = other;
    }
    monitor.resting(j) = resting;
    monitor.witness(j) = static_cast<double>(best.output);
    monitor.rest_min(j) = best.min;
    monitor.rest_max(j) = best.max;
    monitor.most_equal(j) = most_equal_of(monitor, runs, j);
  }
}

}  // namespace nlo::trainer
