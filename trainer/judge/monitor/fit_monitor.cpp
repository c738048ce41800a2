// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/fit_monitor.h"

#include <fmt/format.h>
#include <nlo/monitor_model.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "codegen/fold/fold.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/base/parallel.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/monitor/frozen_sensors.h"

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kHour = 3600.0;
// A smaller share of missing measurements raises no alarm, even if the training had none.
constexpr double kLeastMissing = 0.3;
constexpr double kGateQuantile = 0.9995;
// Smallest gate [deviations]: the quantile of a normal innovation. Innovations from the steps of an encoder are below 3
// deviations, so their own quantile would leave no margin for errors of the prediction.
constexpr double kLeastGate = 3.5;
// kMostOfReach: the largest limit, relative to the largest reachable value of a statistic. kSeenOfReach: such a limit
// is used only if the values in training are below this.
constexpr double kMostOfReach = 0.9, kSeenOfReach = 0.75;
// Limits of the shares of missing samples. A gate that rejects 5 readings of 6 brings the share to 0.92 over 4 samples,
// and to less over more samples.
constexpr double kMostMissing = 0.95, kSeenMissing = 0.93;

/// Training pairs of one run for the prediction: the features of each sample but the last, and the change of y that
/// follows. Samples whose outputs did not arrive are left out, but not those at which a slow output is not due.
struct Steps {
  MatrixXd features, changes, x_hat;
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> arrived = {};  ///< n_y x samples
  Index armed = 0;                                                  // first column at which the observer has settled
};

Steps steps_of(const codegen::Model& model, const codegen::Run& run, const MatrixXd& measured, Index armed_after) {
  const MatrixXd features = codegen::monitor_features(model, run);
  Steps steps{MatrixXd(features.rows(), features.cols()), MatrixXd(model.ny(), features.cols()),
              MatrixXd(model.nx(), features.cols())};
  steps.arrived.setConstant(model.ny(), features.cols(), true);
  const std::vector<int> period = codegen::not_due(model);
  const auto due = [&](Index k) {
    for (Index j = 0; j < model.measured(); ++j)
      if (period[static_cast<std::size_t>(j)] == 0 && !std::isfinite(measured(j, k))) return false;
    return true;
  };
  Index used = 0;
  for (Index k = 1; k < features.cols(); ++k) {
    if (k <= armed_after) steps.armed = used;
    if (!due(k) || !due(k - 1)) continue;
    for (Index j = 0; j < model.ny(); ++j)
      if (period[static_cast<std::size_t>(j)] > 0)
        steps.arrived(j, used) =
            j < model.measured() ? std::isfinite(measured(j, k)) : measured.col(k).head(model.measured()).allFinite();
    steps.features.col(used) = features.col(k - 1);
    steps.x_hat.col(used) = run.x_hat.col(k - 1);
    steps.changes.col(used++) = run.y.col(k).head(model.ny()) - run.y.col(k - 1).head(model.ny());
  }
  steps.features.conservativeResize(Eigen::NoChange, used);
  steps.changes.conservativeResize(Eigen::NoChange, used);
  steps.x_hat.conservativeResize(Eigen::NoChange, used);
  steps.arrived.conservativeResize(Eigen::NoChange, used);
  return steps;
}

/// Returns the steps that end at a sample at which output j arrived, with the changes of this output.
std::vector<Steps> arrivals_of(const std::vector<Steps>& all, Index j) {
  std::vector<Steps> own;
  for (const Steps& steps : all) {
    std::vector<Index> columns;
    Index armed = 0;
    for (Index k = 0; k < steps.changes.cols(); ++k) {
      if (k == steps.armed) armed = static_cast<Index>(columns.size());
      if (steps.arrived(j, k)) columns.push_back(k);
    }
    if (steps.armed >= steps.changes.cols()) armed = static_cast<Index>(columns.size());
    own.push_back({steps.features(Eigen::all, columns),
                   steps.changes(std::vector<Index>{j}, columns),
                   steps.x_hat(Eigen::all, columns),
                   {},
                   armed});
  }
  return own;
}

/// Fits targets = slope features + offset by ridge regression. The ridge is so small that it only matters if features
/// are equal.
struct LinearFit {
  MatrixXd slope;
  VectorXd offset;
};
template <class Features, class Targets>
LinearFit fit_linear(const std::vector<Steps>& all, const Features& features_of, const Targets& targets_of) {
  const Index features = features_of(all.front()).rows(), targets = targets_of(all.front()).rows();
  double count = 0.0;
  VectorXd mean = VectorXd::Zero(features), mean_target = VectorXd::Zero(targets);
  for (const Steps& steps : all) {
    mean += features_of(steps).rowwise().sum();
    mean_target += targets_of(steps).rowwise().sum();
    count += static_cast<double>(features_of(steps).cols());
  }
  if (count < 10.0 * static_cast<double>(features))
    throw codegen::Error(fmt::format(
        "{:.0f} samples are too few for a monitor with {} features; give longer runs or logs", count, features));
  mean /= count;
  mean_target /= count;
  MatrixXd square = MatrixXd::Zero(features, features), mixed = MatrixXd::Zero(features, targets);
  for (const Steps& steps : all) {
    const MatrixXd centred = features_of(steps).colwise() - mean;
    square += centred * centred.transpose();
    mixed += centred * (targets_of(steps).colwise() - mean_target).transpose();
  }
  constexpr double kRidge = 1e-9;
  const double least = 1e-12 * std::max(square.diagonal().maxCoeff(), 1e-300);
  square.diagonal() += kRidge * square.diagonal() + VectorXd::Constant(features, least);
  LinearFit fit{codegen::solve_symmetric(square, mixed).transpose(), {}};
  fit.offset = mean_target - fit.slope * mean;
  return fit;
}

void fit_prediction(Monitor& monitor, const std::vector<Steps>& all, const std::vector<Index>& slow) {
  const auto features = [](const Steps& steps) -> const MatrixXd& { return steps.features; };
  const auto changes = [](const Steps& steps) -> const MatrixXd& { return steps.changes; };
  LinearFit fit = fit_linear(all, features, changes);
  monitor.prediction = std::move(fit.slope);
  monitor.offset = std::move(fit.offset);
  for (const Index j : slow) {
    const LinearFit own = fit_linear(arrivals_of(all, j), features, changes);
    monitor.prediction.row(j) = own.slope;
    monitor.offset(j) = own.offset(0);
  }
}

/// Fits T* linearly after it has settled. States with a linear T* and angles that wrap are not compared.
void fit_row(Monitor& monitor, const codegen::Model& model, const std::vector<Steps>& all) {
  const Index read = model.nz() + model.nr();
  const auto features = [read](const Steps& steps) {
    return steps.features.topRightCorner(read, steps.features.cols() - steps.armed);
  };
  const auto estimates = [](const Steps& steps) { return steps.x_hat.rightCols(steps.x_hat.cols() - steps.armed); };
  Index settled = 0;
  for (const Steps& steps : all) settled += features(steps).cols();
  if (settled < 10 * read) return;  // too few samples; the error about the limits reports it
  const LinearFit fit = fit_linear(all, features, estimates);
  const Index nx = model.nx();
  VectorXd squares = VectorXd::Zero(nx), sum = VectorXd::Zero(nx), all_squares = VectorXd::Zero(nx);
  double count = 0.0;
  for (const Steps& steps : all) {
    const MatrixXd off = (estimates(steps) - fit.slope * features(steps)).colwise() - fit.offset;
    squares += off.rowwise().squaredNorm();
    sum += estimates(steps).rowwise().sum();
    all_squares += estimates(steps).rowwise().squaredNorm();
    count += static_cast<double>(off.cols());
  }
  constexpr double kNonlinear = 1e-3;  // share of the deviation of x_hat
  for (Index i = 0; i < nx; ++i) {
    const double deviation = std::sqrt(squares(i) / count);
    const double spread = std::sqrt(std::max(0.0, all_squares(i) / count - std::pow(sum(i) / count, 2)));
    if (model.states[static_cast<std::size_t>(i)].wrap > 0.0 || !(deviation > kNonlinear * spread)) continue;
    monitor.row.row(i) = fit.slope.row(i);
    monitor.row_offset(i) = fit.offset(i);
    monitor.row_deviation(i) = deviation;
    monitor.disagreement_limit(i) = 1.0;
  }
}

/// Returns mean_r |off_r| of each column, as the monitor computes it.
Eigen::RowVectorXd places(const Monitor& monitor, const MatrixXd& features) {
  const Index nz = monitor.latent_mean.size();
  const MatrixXd off = monitor.latent_deviation.cwiseInverse().asDiagonal() *
                       MatrixXd(features.topRows(nz).colwise() - monitor.latent_mean);
  return off.cwiseAbs().colwise().mean().cwiseMin(kLargestInnovation);
}

/// Innovations of some outputs: mean squares, growth with the distance of z, and innovations after settling.
struct Innovations {
  VectorXd squares, motion;
  std::vector<MatrixXd> sized;  ///< divided by 1 + motion place, for each run
};
Innovations innovations_of(const Monitor& monitor, const MatrixXd& prediction, const VectorXd& offset,
                           const std::vector<Steps>& all) {
  const auto settled = [](const Steps& steps) { return steps.changes.cols() - steps.armed; };
  const auto innovations = [&](const Steps& steps) -> MatrixXd {
    return (steps.changes.rightCols(settled(steps)) - prediction * steps.features.rightCols(settled(steps))).colwise() -
           offset;
  };
  const Index ny = offset.size();
  const auto place = [&](const Steps& steps) { return places(monitor, steps.features.rightCols(settled(steps))); };
  // Fits E |innovation| = a + b place by least squares.
  double count = 0.0, sum_place = 0.0, square_place = 0.0;
  VectorXd sum = VectorXd::Zero(ny), mixed = VectorXd::Zero(ny);
  for (const Steps& steps : all) {
    const MatrixXd size = innovations(steps).cwiseAbs();
    const Eigen::RowVectorXd at = place(steps);
    count += static_cast<double>(size.cols());
    sum_place += at.sum();
    square_place += at.squaredNorm();
    sum += size.rowwise().sum();
    mixed += size * at.transpose();
  }
  const double spread = square_place - sum_place * sum_place / count;
  // Smallest base, as a share of the mean size, because innovations are not zero at the mean of z.
  constexpr double kLeastBase = 0.1;
  Innovations found{VectorXd::Zero(ny), VectorXd::Zero(ny), {}};
  for (Index j = 0; j < ny; ++j) {
    const double slope = spread > 0.0 ? std::max(0.0, (mixed(j) - sum(j) * sum_place / count) / spread) : 0.0;
    const double base = std::max(sum(j) / count - slope * sum_place / count, kLeastBase * sum(j) / count);
    found.motion(j) = base > 0.0 ? std::min(slope / base, 1.0 / kLeastBase) : 0.0;
  }
  for (const Steps& steps : all) {
    MatrixXd e = innovations(steps);
    const Eigen::RowVectorXd at = place(steps);
    for (Index j = 0; j < e.rows(); ++j) e.row(j).array() /= 1.0 + found.motion(j) * at.array();
    found.squares += e.rowwise().squaredNorm();
    found.sized.push_back(std::move(e));
  }
  found.squares /= count;
  return found;
}

/// Fits the deviations of innovations and their growth with the distance of z. The gate is the kGateQuantile of the
/// innovations in training, but at least kLeastGate.
void fit_innovation(Monitor& monitor, const std::vector<Steps>& all, const codegen::Model& model,
                    const std::vector<Index>& slow) {
  Innovations found = innovations_of(monitor, monitor.prediction, monitor.offset, all);
  std::vector<double> sizes;
  const VectorXd least = 1e-9 * (model.output_max - model.output_min);
  const auto deviations = [](const VectorXd& squares, const VectorXd& smallest) -> VectorXd {
    return squares.cwiseSqrt().cwiseMax(smallest);
  };
  const auto add_sizes = [&](const Innovations& of, Index row, double deviation) {
    for (const MatrixXd& e : of.sized)
      for (const double each : e.row(row)) sizes.push_back(std::abs(each * (1.0 / deviation)));
  };
  monitor.deviation = deviations(found.squares, least);
  monitor.motion = found.motion;
  for (Index j = 0; j < model.ny(); ++j) {
    if (std::ranges::find(slow, j) == slow.end()) {
      add_sizes(found, j, monitor.deviation(j));
      continue;
    }
    const Innovations own =
        innovations_of(monitor, monitor.prediction.row(j), monitor.offset.segment(j, 1), arrivals_of(all, j));
    monitor.deviation(j) = deviations(own.squares, least.segment(j, 1))(0);
    monitor.motion(j) = own.motion(0);
    add_sizes(own, 0, monitor.deviation(j));
  }
  const auto at = static_cast<std::ptrdiff_t>(kGateQuantile * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), sizes.begin() + at, sizes.end());
  monitor.gate = std::max(kLeastGate, sizes[static_cast<std::size_t>(at)]);
}

void fit_place(Monitor& monitor, const codegen::Model& model, const std::vector<Steps>& all) {
  const Index nz = model.nz();
  VectorXd sum = VectorXd::Zero(nz), squares = VectorXd::Zero(nz);
  double count = 0.0;
  const auto settled = [nz](const Steps& steps) {
    return steps.features.topRightCorner(nz, steps.features.cols() - steps.armed);
  };
  for (const Steps& steps : all) {
    sum += settled(steps).rowwise().sum();
    count += static_cast<double>(settled(steps).cols());
  }
  monitor.latent_mean = sum / count;
  for (const Steps& steps : all) squares += (settled(steps).colwise() - monitor.latent_mean).rowwise().squaredNorm();
  constexpr double kLeast = 0.05;  // smallest spread, as a share of the domain; a decayed clock contains no information
  const VectorXd least = kLeast * (model.latent_max - model.latent_min);
  monitor.latent_deviation = (squares / count).cwiseSqrt().cwiseMax(least);
}

/// Time after which a monitor arms, and the error of x_hat then, divided by the settled one.
struct Settled {
  Index samples;
  double error;
};
constexpr double kSettled = 2.0;  // largest such error of an estimate that has settled

/// Returns the time after which x_hat has settled, in whole quarters of a time constant. It is the first quarter that
/// meets both conditions:
///   - after the starts of the runs, the rms error is at most twice the error in the second halves of the runs. Only
///     three time constants count, because the plant may move more at the beginning of its runs
///   - after restarts in the middle of the runs, it is at most twice that error, or twice the error that the observer
///     without a restart has in the same samples
/// If no quarter does, it is three time constants or half of the shortest run, whichever is longer. It is one time
/// constant without runs.
Settled settled_after(const codegen::Model& model, const std::vector<FlownRun>& runs, Index block) {
  constexpr Index kQuarters = 4, kStartQuarters = 12;
  if (runs.empty()) return {block, 0.0};
  const Index length = std::max<Index>(1, block / kQuarters);
  Index shortest = runs.front().samples();
  for (const FlownRun& run : runs) shortest = std::min(shortest, run.samples());
  const Index most = std::max(kStartQuarters, shortest / 2 / length);

  const VectorXd deviations = state_deviations(runs);
  const ObserverRun observer = observer_run(model, runs.front().time_s.size() == 0);
  const auto estimates = [&](const FlownRun& run) {
    const VectorXd time =
        run.time_s.size() > 0
            ? run.time_s
            : VectorXd::LinSpaced(run.samples(), 0.0, static_cast<double>(run.samples() - 1) * model.sample_period_s);
    return observer(run.outputs, run.inputs, time).x_hat;
  };
  using Quarters = std::vector<ErrorSum>;  // errors in each quarter of a time constant after a sample, over all runs
  const auto add = [&](Quarters& quarters, const FlownRun& run, const MatrixXd& x_hat) {
    for (Index i = 0; i < most; ++i)
      quarters[static_cast<std::size_t>(i)] += error_sum(model, run, x_hat, deviations, i * length, (i + 1) * length);
  };
  Quarters started(static_cast<std::size_t>(most)), restarted = started, kept = started;
  ErrorSum late;
  for (const FlownRun& run : runs) {
    const MatrixXd x_hat = estimates(run);
    add(started, run, x_hat);
    late += error_sum(model, run, x_hat, deviations, run.samples() / 2);
    for (const Index n : {1, 2, 3}) {
      const FlownRun rest = run.from(n * run.samples() / 4);
      if (rest.samples() < length) continue;
      add(restarted, rest, estimates(rest));
      add(kept, rest, x_hat.rightCols(rest.samples()));
    }
  }
  const auto start_error = [&](std::size_t i) { return started[i].rms() / late.rms(); };
  const auto restart_error = [&](std::size_t i) { return restarted[i].rms() / std::max(late.rms(), kept[i].rms()); };
  auto i = static_cast<std::size_t>(kQuarters);
  const auto unsettled = [&] {
    return (i < kStartQuarters && start_error(i) > kSettled) || restart_error(i) > kSettled;
  };
  while (i < started.size() && unsettled()) ++i;
  const std::size_t last = std::min(i, started.size() - 1);
  const Index quarters = static_cast<Index>(i);
  return {quarters % kQuarters == 0 ? quarters / kQuarters * block : quarters * length,
          std::max(start_error(last), restart_error(last))};
}

/// Sets all limits to 1, so that levels are the statistics themselves.
void clear_limits(Monitor& monitor, Index ny) {
  const Index windows = monitor.windows();
  monitor.mean_limit = monitor.variance_limit = monitor.correlation_limit = MatrixXd::Ones(ny, windows);
  monitor.latent_limit = VectorXd::Ones(windows);
  monitor.missing_limit = VectorXd::Ones(ny);
  monitor.disagreement_limit =
      monitor.row_deviation.unaryExpr([](double deviation) { return deviation > 0.0 ? 1.0 : 0.0; });
}

/// A statistic, in the order of ReferenceMonitor::levels(): its name, and the largest value that it keeps while a fault
/// lasts.
struct Statistic {
  std::string name;
  double reach = 0.0;
  double most = kMostOfReach * reach, seen = kSeenOfReach * reach;  ///< largest limit, and largest value in training
};
std::vector<Statistic> statistics_of(const codegen::Model& model, const Monitor& monitor) {
  constexpr double kMostSquare = kLargestInnovation * kLargestInnovation;
  std::vector<Statistic> all;
  for (const codegen::Channel& output : model.outputs)
    for (Index w = 0; w < monitor.windows(); ++w) {
      const std::string of = fmt::format("of {} over {:.3g} s", output.name, monitor.windows_s(w));
      all.push_back({"innovation mean " + of, 1.0});
      all.push_back({"innovation variance " + of, kMostSquare});
      all.push_back({"innovation correlation " + of, kMostSquare});
    }
  for (Index w = 0; w < monitor.windows(); ++w)
    all.push_back({fmt::format("latent distance over {:.3g} s", monitor.windows_s(w)), kMostSquare});
  for (const codegen::Channel& output : model.outputs)
    all.push_back({"missing share of " + output.name, 1.0, kMostMissing, kSeenMissing});
  for (const codegen::Channel& state : model.states) all.push_back({"disagreement on " + state.name, kMostSquare});
  return all;
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
  monitor.missing_limit = limits.segment(at + windows, ny);
  for (Index i = 0; i < monitor.row_deviation.size(); ++i)
    if (monitor.row_deviation(i) > 0.0) monitor.disagreement_limit(i) = limits(at + windows + ny + i);
}

/// Returns the largest levels in each block of `block` samples after the start, for each run.
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

FittedMonitor fit_monitor(const codegen::Model& model, const SensedRuns& fit, const RunSource& limits,
                          const std::optional<SensedRuns>& clean, const std::vector<FlownRun>& trial,
                          const MonitorRequest& request, const MonitorProgress& progress) {
  const double tau = request.time_constant_s;
  const Index block = std::max<Index>(1, std::lround(tau / model.sample_period_s)), ny = model.ny();
  FittedMonitor fitted;
  Monitor& monitor = fitted.monitor;
  monitor.windows_s = Eigen::Vector3d(tau / 4.0, tau, 2.0 * tau);
  const auto [armed, error] = settled_after(model, trial, block);
  monitor.armed_after_s = static_cast<double>(armed) * model.sample_period_s;
  if (error > kSettled)
    fitted.notes.push_back(fmt::format(
        "the monitor arms {:.3g} s after a start, when the error is still {:.2g} times that of the settled estimate",
        monitor.armed_after_s, error));
  monitor.false_alarms_per_hour = request.false_alarms_per_hour;
  codegen::leave_out_frozen(monitor, ny);
  codegen::leave_out_motion_and_row(monitor, ny, model.nx(), model.nz() + model.nr());

  const ObserverRun observer = observer_run(model, fit.uniform());
  std::vector<Steps> steps;
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const Index samples = fit.outputs[i].cols();
    const VectorXd time =
        fit.uniform() ? VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) * model.sample_period_s)
                      : fit.time_s[i];
    steps.push_back(steps_of(model, observer(fit.outputs[i], fit.inputs[i], time), fit.outputs[i], armed));
  }
  std::vector<Index> slow;
  const std::vector<int> period = codegen::not_due(model);
  for (Index j = 0; j < ny; ++j)
    if (period[static_cast<std::size_t>(j)] > 0) slow.push_back(j);
  fit_prediction(monitor, steps, slow);
  fit_place(monitor, model, steps);
  fit_innovation(monitor, steps, model, slow);
  fit_row(monitor, model, steps);
  steps.clear();
  clear_limits(monitor, ny);
  monitor.least_variance = VectorXd::Constant(ny, clean ? 1e-9 : 1.0);
  monitor.hours = 1.0;
  ThreadPool pool(request.threads);
  fit_frozen(monitor, fit, clean.has_value(), model);
  const std::optional<GateTrial> replacing = replace_lost_readings(model, monitor, trial, pool);
  fitted.gate = drop_harmful_gates(model, monitor, trial, block, pool);
  fitted.gate.replacing = replacing;

  // Computes the largest statistics of all blocks, and then the limits.
  std::vector<VectorXd> maxima;
  for (int chunk = 0; chunk < limits.chunks; ++chunk) {
    const std::vector<VectorXd> own = block_maxima(model, monitor, limits.chunk(chunk), block, pool);
    maxima.insert(maxima.end(), own.begin(), own.end());
    if (progress) progress(static_cast<double>(chunk + 1) / static_cast<double>(limits.chunks));
  }
  constexpr std::size_t kFewest = 8;
  if (maxima.size() < kFewest)
    throw codegen::Error(
        fmt::format("{} time constants of {:.3g} s after the start are too few to set limits; give longer runs or "
                    "logs, or a shorter --time-constant",
                    maxima.size(), tau));
  monitor.hours = static_cast<double>(maxima.size() * static_cast<std::size_t>(block)) * model.sample_period_s / kHour;
  const std::vector<Statistic> statistics = statistics_of(model, monitor);
  const auto count = static_cast<Index>(statistics.size());
  const auto of_all = [&](const auto& value) {
    std::vector<double> values;
    for (const VectorXd& one : maxima) values.push_back(value(one));
    return values;
  };
  VectorXd found(count);
  for (Index q = 0; q < count; ++q)
    found(q) = std::max(1e-9, exceeded_at_rate(of_all([q](const VectorXd& one) { return one(q); }), monitor.hours,
                                               request.false_alarms_per_hour / static_cast<double>(count)));
  found.segment(count - model.nx() - ny, ny) = found.segment(count - model.nx() - ny, ny).cwiseMax(kLeastMissing);
  // If a statistic cannot reach its limit, it gets a lower one, provided that its values in training are below it.
  // Otherwise it is not watched.
  const auto reachable = [&](double limit, Index q) {
    const Statistic& statistic = statistics[static_cast<std::size_t>(q)];
    if (limit < statistic.most) return limit;
    const std::vector<double> values = of_all([q](const VectorXd& one) { return one(q); });
    return *std::max_element(values.begin(), values.end()) < statistic.seen ? statistic.most : kNoLimit;
  };
  for (Index q = 0; q < count; ++q) found(q) = reachable(found(q), q);
  const double together =
      exceeded_at_rate(of_all([&](const VectorXd& one) { return one.cwiseQuotient(found).maxCoeff(); }), monitor.hours,
                       request.false_alarms_per_hour);
  for (Index q = 0; q < count; ++q) {
    if (found(q) < kNoLimit) found(q) = reachable(found(q) * std::max(together, 0.5), q);
    if (found(q) == kNoLimit) fitted.unwatched.push_back(statistics[static_cast<std::size_t>(q)].name);
  }
  set_limits(monitor, ny, found);
  if (!clean) return fitted;

  // Without noise, prediction errors are errors of the model, which hardly change between samples.
  Monitor unscaled = monitor;
  constexpr double kHuge = 1e12;
  unscaled.least_variance.setConstant(kHuge);
  unscaled.mean_limit.setConstant(1.0 / kHuge);
  VectorXd largest = VectorXd::Constant(ny, 1e-9);
  for (const VectorXd& one : block_maxima(model, unscaled, *clean, block, pool))
    for (Index j = 0; j < ny; ++j)
      for (Index w = 0; w < monitor.windows(); ++w) {
        const double limit = monitor.mean_limit(j, w);
        if (limit < kNoLimit) largest(j) = std::max(largest(j), one((j * monitor.windows() + w) * 3) / limit);
      }
  constexpr double kMargin = 2.0;
  monitor.least_variance = kMargin * largest;
  return fitted;
}

}  // namespace nlo::trainer
