// SPDX-License-Identifier: MIT
#include "trainer/monitor/fit_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/base/parallel.h"
#include "trainer/evaluation/evaluate.h"
#include "trainer/monitor/frozen_sensors.h"

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kHour = 3600.0;
// A share of missing measurements that is no alarm, however complete training was.
constexpr double kLeastMissing = 0.3;
constexpr double kGateQuantile = 0.9995;
constexpr double kLeastGate = 3.0;  // deviations

/// What predictions are fitted to, of one run: the features of each sample but the last, and the change that follows.
struct Steps {
  MatrixXd features, changes;  // without those whose outputs did not arrive
  Index armed = 0;             // from this column on the observer has settled
};

Steps steps_of(const codegen::Model& model, const codegen::Run& run, const MatrixXd& measured, Index armed_after) {
  const MatrixXd features = codegen::monitor_features(model, run);
  Steps steps{MatrixXd(features.rows(), features.cols()), MatrixXd(model.ny(), features.cols())};
  Index used = 0;
  for (Index k = 1; k < features.cols(); ++k) {
    if (k <= armed_after) steps.armed = used;
    if (!measured.col(k).allFinite() || !measured.col(k - 1).allFinite()) continue;
    steps.features.col(used) = features.col(k - 1);
    steps.changes.col(used++) = run.y.col(k).head(model.ny()) - run.y.col(k - 1).head(model.ny());
  }
  steps.features.conservativeResize(Eigen::NoChange, used);
  steps.changes.conservativeResize(Eigen::NoChange, used);
  return steps;
}

/// P and c by ridge regression with so small a weight that it decides between features alone that say the same.
void fit_prediction(Monitor& monitor, const std::vector<Steps>& all) {
  const Index features = all.front().features.rows(), ny = all.front().changes.rows();
  double count = 0.0;
  VectorXd mean = VectorXd::Zero(features), mean_change = VectorXd::Zero(ny);
  for (const Steps& steps : all) {
    mean += steps.features.rowwise().sum();
    mean_change += steps.changes.rowwise().sum();
    count += static_cast<double>(steps.features.cols());
  }
  if (count < 10.0 * static_cast<double>(features))
    throw codegen::Error(fmt::format(
        "{:.0f} samples are too few to make a monitor of {} features; give longer runs or logs", count, features));
  mean /= count;
  mean_change /= count;
  MatrixXd square = MatrixXd::Zero(features, features), mixed = MatrixXd::Zero(features, ny);
  for (const Steps& steps : all) {
    const MatrixXd centred = steps.features.colwise() - mean;
    square += centred * centred.transpose();
    mixed += centred * (steps.changes.colwise() - mean_change).transpose();
  }
  constexpr double kRidge = 1e-9;
  const double least = 1e-12 * std::max(square.diagonal().maxCoeff(), 1e-300);
  square.diagonal() += kRidge * square.diagonal() + VectorXd::Constant(features, least);
  monitor.prediction = codegen::solve_symmetric(square, mixed).transpose();
  monitor.offset = mean_change - monitor.prediction * mean;
}

/// Deviations of innovations, and the gate: beyond what training's sensors do.
void fit_innovation(Monitor& monitor, const std::vector<Steps>& all, const codegen::Model& model) {
  VectorXd squares = VectorXd::Zero(model.ny());
  double count = 0.0;
  const auto innovations = [&](const Steps& steps) -> MatrixXd {
    const Index armed = steps.changes.cols() - steps.armed;
    return (steps.changes.rightCols(armed) - monitor.prediction * steps.features.rightCols(armed)).colwise() -
           monitor.offset;
  };
  for (const Steps& steps : all) {
    squares += innovations(steps).rowwise().squaredNorm();
    count += static_cast<double>(steps.changes.cols() - steps.armed);
  }
  const VectorXd least = 1e-9 * (model.output_max - model.output_min);
  monitor.deviation = (squares / count).cwiseSqrt().cwiseMax(least);
  std::vector<double> sizes;
  for (const Steps& steps : all) {
    const MatrixXd scaled = monitor.deviation.cwiseInverse().asDiagonal() * innovations(steps);
    for (const double e : scaled.reshaped()) sizes.push_back(std::abs(e));
  }
  const auto at = static_cast<std::ptrdiff_t>(kGateQuantile * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), sizes.begin() + at, sizes.end());
  monitor.gate = std::max(kLeastGate, sizes[static_cast<std::size_t>(at)]);
}

void fit_place(Monitor& monitor, const codegen::Model& model, const std::vector<Steps>& all) {
  const Index nz = model.nz();
  VectorXd sum = VectorXd::Zero(nz), squares = VectorXd::Zero(nz);
  double count = 0.0;
  const auto places = [nz](const Steps& steps) {
    return steps.features.topRightCorner(nz, steps.features.cols() - steps.armed);
  };
  for (const Steps& steps : all) {
    sum += places(steps).rowwise().sum();
    count += static_cast<double>(places(steps).cols());
  }
  monitor.latent_mean = sum / count;
  for (const Steps& steps : all) squares += (places(steps).colwise() - monitor.latent_mean).rowwise().squaredNorm();
  constexpr double kLeast = 0.05;  // of the domain: a clock that has run out says nothing
  const VectorXd least = kLeast * (model.latent_max - model.latent_min);
  monitor.latent_deviation = (squares / count).cwiseSqrt().cwiseMax(least);
}

/// All limits at 1: levels are the statistics themselves.
void clear_limits(Monitor& monitor, Index ny) {
  const Index windows = monitor.windows();
  monitor.mean_limit = monitor.variance_limit = monitor.correlation_limit = MatrixXd::Ones(ny, windows);
  monitor.latent_limit = VectorXd::Ones(windows);
  monitor.missing_limit = VectorXd::Ones(ny);
}

void set_limits(Monitor& monitor, Index ny, const VectorXd& limits) {
  const Index windows = monitor.windows();
  Index at = 0;
  for (Index j = 0; j < ny; ++j)
    for (Index w = 0; w < windows; ++w) {
      monitor.mean_limit(j, w) = limits(at++);
      monitor.variance_limit(j, w) = limits(at++);
      monitor.correlation_limit(j, w) = limits(at++);
    }
  monitor.latent_limit = limits.segment(at, windows);
  monitor.missing_limit = limits.tail(ny);
}

/// The largest levels in each block of `block` samples after the start, of each run.
std::vector<VectorXd> block_maxima(const codegen::Model& model, const Monitor& monitor, const SensedRuns& runs,
                                   Index block, ThreadPool& pool) {
  std::vector<std::vector<VectorXd>> each(runs.size());
  pool.run(static_cast<int>(runs.size()), [&](int index, int) {
    const auto i = static_cast<std::size_t>(index);
    const codegen::WatchedRun watched =
        codegen::watched_run(model, monitor, runs.outputs[i], runs.inputs[i], runs.stamps(i));
    for (Index k = watched.armed_after; k + block <= watched.levels.cols(); k += block)
      each[i].emplace_back(watched.levels.middleCols(k, block).rowwise().maxCoeff());
  });
  std::vector<VectorXd> all;
  for (const auto& run : each) all.insert(all.end(), run.begin(), run.end());
  return all;
}

}  // namespace

double exceeded_at_rate(std::vector<double> values, double hours, double per_hour) {
  std::sort(values.begin(), values.end(), std::greater<>());
  const std::size_t beyond = std::min(std::max<std::size_t>(20, values.size() / 200), (values.size() - 1) / 2);
  const double from = values[beyond];
  double excess = 0.0;
  for (std::size_t i = 0; i < beyond; ++i) excess += values[i] - from;
  const double count = static_cast<double>(std::max<std::size_t>(beyond, 1));
  return from + excess / count * std::log(count / hours / per_hour);
}

Monitor fit_monitor(const codegen::Model& model, const SensedRuns& fit, const RunSource& limits,
                    const std::optional<SensedRuns>& clean, const MonitorRequest& request,
                    const MonitorProgress& progress) {
  const double tau = request.time_constant_s;
  const Index block = std::max<Index>(1, std::lround(tau / model.sample_period_s)), ny = model.ny();
  Monitor monitor;
  monitor.windows_s = Eigen::Vector3d(tau / 4.0, tau, 2.0 * tau);
  monitor.armed_after_s = static_cast<double>(block) * model.sample_period_s;
  monitor.false_alarms_per_hour = request.false_alarms_per_hour;

  const ObserverRun observer = observer_run(model, fit.uniform());
  std::vector<Steps> steps;
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const Index samples = fit.outputs[i].cols();
    const VectorXd time =
        fit.uniform() ? VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) * model.sample_period_s)
                      : fit.time_s[i];
    steps.push_back(steps_of(model, observer(fit.outputs[i], fit.inputs[i], time), fit.outputs[i], block));
  }
  fit_prediction(monitor, steps);
  fit_innovation(monitor, steps, model);
  // How a sensor repeats itself only its logs show: what is simulated has no resolution.
  fit_frozen(monitor, clean ? SensedRuns{} : fit, model);
  fit_place(monitor, model, steps);
  steps.clear();

  // Statistics as they are, then their limits.
  clear_limits(monitor, ny);
  monitor.least_variance = VectorXd::Constant(ny, clean ? 1e-9 : 1.0);
  monitor.hours = 1.0;
  ThreadPool pool(request.threads);
  std::vector<VectorXd> maxima;
  for (int chunk = 0; chunk < limits.chunks; ++chunk) {
    const std::vector<VectorXd> own = block_maxima(model, monitor, limits.chunk(chunk), block, pool);
    maxima.insert(maxima.end(), own.begin(), own.end());
    if (progress) progress(static_cast<double>(chunk + 1) / static_cast<double>(limits.chunks));
  }
  constexpr std::size_t kFewest = 8;
  if (maxima.size() < kFewest)
    throw codegen::Error(fmt::format(
        "{} time constants of {:.3g} s after the start are too few to set limits on; give longer runs or logs, "
        "or a shorter --time-constant",
        maxima.size(), tau));
  monitor.hours = static_cast<double>(maxima.size() * static_cast<std::size_t>(block)) * model.sample_period_s / kHour;
  const Index statistics = maxima.front().size();
  const auto of_all = [&](const auto& value) {
    std::vector<double> values;
    for (const VectorXd& one : maxima) values.push_back(value(one));
    return values;
  };
  VectorXd found(statistics);
  for (Index q = 0; q < statistics; ++q)
    found(q) = std::max(1e-9, exceeded_at_rate(of_all([q](const VectorXd& one) { return one(q); }), monitor.hours,
                                               request.false_alarms_per_hour / static_cast<double>(statistics)));
  found.tail(ny) = found.tail(ny).cwiseMax(kLeastMissing);
  const double together =
      exceeded_at_rate(of_all([&](const VectorXd& one) { return one.cwiseQuotient(found).maxCoeff(); }), monitor.hours,
                       request.false_alarms_per_hour);
  found *= std::max(together, 0.5);
  set_limits(monitor, ny, found);
  if (!clean) return monitor;

  // Without noise predictions are off by what they cannot say, sample after sample alike: p is near v.
  Monitor unscaled = monitor;
  constexpr double kHuge = 1e12;
  unscaled.least_variance.setConstant(kHuge);
  unscaled.mean_limit /= kHuge;
  VectorXd largest = VectorXd::Constant(ny, 1e-9);
  for (const VectorXd& one : block_maxima(model, unscaled, *clean, block, pool))
    for (Index j = 0; j < ny; ++j)
      for (Index w = 0; w < monitor.windows(); ++w)
        largest(j) = std::max(largest(j), one((j * monitor.windows() + w) * 3));
  constexpr double kMargin = 2.0;
  monitor.least_variance = kMargin * largest;
  return monitor;
}

}  // namespace nlo::trainer
