// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/monitor_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "codegen/base/error.h"
#include "trainer/base/parallel.h"
#include "trainer/base/quantile.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/study.h"

namespace nlo::trainer {
namespace {

using codegen::WatchedRun;
using Eigen::Index;
using Eigen::MatrixXd;
using nlo::Alarm;

constexpr double kSeenWithin = 5.0;  // time constants
constexpr double kShortestRun = 8.0;
constexpr std::size_t kFaultRuns = 20;
constexpr Index kMostFaultSamples = 20000;
constexpr std::size_t kAlarms = static_cast<std::size_t>(Alarm::kReset) + 1;

/// Means of squared errors of one run once armed, without and with the gate.
struct Errors {
  double plain = 0.0, gated = 0.0;
};

}  // namespace

AlarmCount count_alarms(const std::vector<WatchedRun>& runs, double sample_period_s, double time_constant_s) {
  const auto quiet = static_cast<Index>(std::lround(time_constant_s / sample_period_s));
  AlarmCount count;
  std::vector<double> delays;
  std::array<int, kAlarms> kinds{};
  double hours = 0.0, alarms = 0.0, seen = 0.0;
  for (const WatchedRun& run : runs) {
    Index until = -1;
    bool first = true;
    const auto samples = static_cast<Index>(run.alarms.size());
    for (Index k = run.armed_after; k < samples; ++k) {
      const Alarm alarm = run.alarms[static_cast<std::size_t>(k)];
      if (alarm == Alarm::kNone) continue;
      if (k >= until) alarms += 1.0;
      until = k + quiet;
      if (!first) continue;
      first = false;
      const double delay_s = static_cast<double>(k - run.armed_after) * sample_period_s;
      delays.push_back(delay_s);
      if (delay_s <= kSeenWithin * time_constant_s) seen += 1.0;
      ++kinds[static_cast<std::size_t>(alarm)];
    }
    hours += static_cast<double>(std::max<Index>(0, samples - run.armed_after)) * sample_period_s / 3600.0;
  }
  count.seen = runs.empty() ? 0.0 : seen / static_cast<double>(runs.size());
  count.per_hour = hours > 0.0 ? alarms / hours : 0.0;
  if (!delays.empty()) {
    count.median_delay_s = value_at_rank(delays, 0.5);
    count.most = static_cast<Alarm>(std::max_element(kinds.begin(), kinds.end()) - kinds.begin());
  }
  return count;
}

MonitorStudy study_monitor(const codegen::Model& model, const Experiment& experiment, const Condition& trained,
                           const ConditionSet& set, double time_constant_s, int runs, double hours, std::uint64_t seed,
                           int threads, const MonitorProgress& progress) {
  MonitorStudy study;
  std::vector<Condition> conditions = compared_conditions(experiment, set, study.left_out);
  conditions.insert(conditions.begin(), trained);
  Experiment nominal = nominal_experiment(experiment);
  nominal.simulation.horizon_s = std::max(nominal.simulation.horizon_s, kShortestRun * time_constant_s);
  const codegen::Monitor& monitor = *model.monitor;
  study.time_constant_s = time_constant_s;
  study.horizon_s = nominal.simulation.horizon_s;
  study.runs = runs;
  ThreadPool pool(threads);
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const int own =
        c > 0 ? runs : std::max(runs, static_cast<int>(std::ceil(hours * 3600.0 / nominal.simulation.horizon_s)));
    std::optional<ComparedRuns> runs_there;
    try {
      runs_there = compared_runs(nominal, conditions[c], SeedStream::kTest, seed, 1, own);
    } catch (const codegen::Error& error) {  // for example an output that is not finite
      if (c == 0) throw;
      study.impossible.push_back(conditions[c].name + ": " + error.what());
      continue;
    }
    const ComparedRuns& compared = *runs_there;
    std::vector<WatchedRun> watched(compared.outputs.size());
    std::vector<Errors> errors(compared.outputs.size());
    std::vector<ObserverRun> observers;
    for (int t = 0; t < pool.threads(); ++t) observers.push_back(observer_run(model, true));
    pool.run(static_cast<int>(compared.outputs.size()), [&](int index, int thread) {
      const auto i = static_cast<std::size_t>(index);
      const Trajectory& truth = compared.set.trajectories[i];
      watched[i] = codegen::watched_run(model, monitor, compared.outputs[i], truth.inputs);
      const MatrixXd plain =
          observers[static_cast<std::size_t>(thread)](compared.outputs[i], truth.inputs, truth.time_s).x_hat;
      const Index armed = watched[i].armed_after;
      errors[i] = {squared_error(compared, i, plain, armed), squared_error(compared, i, watched[i].run.x_hat, armed)};
      watched[i].run = {};
    });
    MonitorRow row;
    row.condition = conditions[c].name;
    double samples = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      row.error += errors[i].plain;
      row.gated += errors[i].gated;
      row.rejected += static_cast<double>(watched[i].rejected);
      samples += static_cast<double>(compared.outputs[i].size());
    }
    const auto count = static_cast<double>(errors.size());
    row.error = std::sqrt(row.error / count);
    row.gated = std::sqrt(row.gated / count);
    row.rejected /= samples;
    row.ratio = study.rows.empty() ? 1.0 : row.error / study.rows.front().error;
    row.alarms = count_alarms(watched, model.sample_period_s, time_constant_s);
    study.rows.push_back(row);
    if (c == 0) {
      std::vector<FlownRun> flown = flown_runs(compared, kMostFaultSamples);
      flown.resize(std::min<std::size_t>(flown.size(), kFaultRuns));
      study.faults = try_faults(model, monitor, flown, pool);
    }
    if (progress) progress(static_cast<double>(c + 1) / static_cast<double>(conditions.size()));
  }
  return study;
}

MonitorStudy study_on_logs(const codegen::Model& model, const Dataset& logs, int threads) {
  MonitorStudy study;
  if (logs.trajectories.empty()) return study;
  const SensedRuns runs = sensed_runs(logs);
  std::vector<WatchedRun> watched;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    watched.push_back(codegen::watched_run(model, *model.monitor, runs.outputs[i], runs.inputs[i], runs.stamps(i)));
    study.log_hours += static_cast<double>(runs.outputs[i].cols()) * model.sample_period_s / 3600.0;
  }
  study.time_constant_s = model.monitor->windows_s(1);
  study.on_logs = count_alarms(watched, model.sample_period_s, study.time_constant_s);
  ThreadPool pool(threads);
  study.faults = try_faults(model, *model.monitor, flown_runs(logs, kMostFaultSamples), pool);
  return study;
}

}  // namespace nlo::trainer
