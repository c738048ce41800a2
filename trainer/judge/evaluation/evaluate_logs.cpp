// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluate_logs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "codegen/base/error.h"
#include "codegen/structures/structure_module.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/examples.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

/// Returns the data as an observer in flight gets them: empty cells of a log are NaN, and the other values have noise.
Dataset with_empty_cells(Dataset data) {
  for (Trajectory& run : data.trajectories) run.outputs = run.measured();
  return data;
}

void require_same_names(const std::vector<Channel>& model, const std::vector<Channel>& data, const char* what) {
  const bool same = std::equal(model.begin(), model.end(), data.begin(), data.end(),
                               [](const Channel& a, const Channel& b) { return a.name == b.name && a.wrap == b.wrap; });
  if (same) return;
  const auto list = [](const std::vector<Channel>& channels) {
    std::string text;
    for (const Channel& channel : channels) text += (text.empty() ? "" : ", ") + channel.name;
    return text;
  };
  throw Error(std::string("evaluation: the model's ") + what + " are " + list(model) + "; the logs give " + list(data) +
              " (names, order and wraps must agree: use the columns that the model was trained with)");
}

/// Returns the rows, among the model's states, of the states for which the logs have a truth.
std::vector<Eigen::Index> scored_states(const codegen::Model& model, const Dataset& logs) {
  std::vector<Eigen::Index> rows;
  for (const Channel& truth : logs.states) {
    const auto found = std::find_if(model.states.begin(), model.states.end(), [&](const Channel& state) {
      return state.name == truth.name && state.wrap == truth.wrap;
    });
    if (found == model.states.end()) require_same_names(model.states, logs.states, "states");
    rows.push_back(found - model.states.begin());
  }
  return rows;
}

/// Returns notes that compare the observer with the alternatives. `entries`: the observer first.
std::vector<std::string> compared(const std::vector<LogEntry>& entries) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const LogMetrics& ours = entries.front().metrics;
  std::vector<ComparedState> states;
  for (std::size_t i = 0; i < ours.pooled.size(); ++i) {
    // Logs that end before the settled window are evaluated as a whole.
    const std::size_t settled = settled_window(ours.windows);
    const std::size_t window = std::isfinite(ours.pooled[i].rmse[settled]) ? settled : 0;
    ComparedState state{ours.pooled[i].name,
                        ours.pooled[i].unit,
                        window_text(ours.windows[window]),
                        ours.pooled[i].rmse[window],
                        kNone,
                        kNone};
    for (const LogEntry& entry : entries) {
      const double error = entry.metrics.pooled[i].rmse[window];
      if (entry.estimator == "constant") {
        state.constant = error;
      } else if (&entry != &entries.front() && std::isfinite(error) && !(error >= state.simple)) {
        state.simple = error;
        // Entries beyond the states are angles, as sine and cosine; they have no description.
        state.simple_name = i < entry.describe.size() ? entry.describe[i] : entry.estimator;
      }
    }
    states.push_back(std::move(state));
  }
  return comparison_notes(states);
}

}  // namespace

Unscored find_unscored(const Dataset& logs) {
  double first_s = 0.0, last_s = 0.0;
  Eigen::Index samples = 0, unscored = 0, inside = 0;
  for (const Trajectory& run : logs.trajectories) {
    const Eigen::Index n = run.samples();
    Eigen::Index from = 0, to = n;
    while (from < n && run.weight[from] <= 0.0) ++from;
    while (to > from && run.weight[to - 1] <= 0.0) --to;
    if (from > 0) first_s = std::max(first_s, run.time_s[std::min(from, n - 1)] - run.time_s[0]);
    if (to < n) last_s = std::max(last_s, run.time_s[n - 1] - run.time_s[std::max<Eigen::Index>(to - 1, 0)]);
    const Eigen::Index within = (run.weight.segment(from, to - from).array() <= 0.0).count();
    samples += n;
    unscored += from + (n - to) + within;
    inside += within;
  }
  Unscored result;
  if (unscored == 0) return result;
  result.share = static_cast<double>(unscored) / static_cast<double>(samples);
  const auto add = [&](const std::string& place) { result.where += (result.where.empty() ? "" : " and ") + place; };
  if (first_s > 0.0) add(fmt::format("the first {} s", significant(first_s, 2)));
  if (last_s > 0.0) add(fmt::format("the last {} s", significant(last_s, 2)));
  if (!result.where.empty()) result.where += " of each log";
  if (inside > 0) add(fmt::format("{} samples inside", inside));
  return result;
}

std::vector<std::string> unscored_notes(const Dataset& logs, const std::vector<Eigen::MatrixXd>& estimates) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < logs.states.size(); ++i) {
    const Channel& state = logs.states[i];
    if (state.wrap > 0.0) continue;
    const auto row = static_cast<Eigen::Index>(i);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Trajectory& run : logs.trajectories)
      for (Eigen::Index k = 0; k < run.samples(); ++k) {
        if (run.weight[k] <= 0.0) continue;
        low = std::min(low, run.states(row, k));
        high = std::max(high, run.states(row, k));
      }
    const double margin = 0.5 * (high - low);
    double farthest = 0.0;
    std::string note;
    for (std::size_t log = 0; log < estimates.size(); ++log) {
      const Trajectory& run = logs.trajectories[log];
      for (Eigen::Index k = 0; k < run.samples(); ++k) {
        if (run.weight[k] > 0.0) continue;
        const double value = estimates[log](row, k);
        const double beyond = std::max(low - margin - value, value - high - margin);
        if (!(beyond > farthest)) continue;
        farthest = beyond;
        const std::string unit = state.unit.empty() ? "" : " " + state.unit;
        note = fmt::format(
            "{} is estimated as {}{} at t = {} s of {}, where the truth is unknown and nothing is scored; in scored "
            "samples it is between {} and {}{}",
            state.name, significant(value), unit, significant(run.time_s[k]), run.source, significant(low),
            significant(high), unit);
      }
    }
    if (!note.empty()) notes.push_back(note);
  }
  return notes;
}

/// Returns groups of states: angles by sine and cosine, and directions if the model estimates them, found by the common
/// part of their components' names.
std::vector<AnglePair> angles_of(const LogSchema& schema, const codegen::Model& model, std::size_t scored) {
  std::vector<AnglePair> angles = schema.angle_pairs;
  if (scored != model.states.size() || !codegen::module_of(model).estimates_directions(model)) return angles;
  for (std::size_t i = 0; i < scored; i += 3) {
    const std::string &first = model.states[i].name, &last = model.states[i + 2].name;
    std::string shared(first.begin(), std::mismatch(first.begin(), first.end(), last.begin(), last.end()).first);
    while (!shared.empty() && shared.back() == '_') shared.pop_back();
    angles.push_back({shared.empty() ? first + "_direction" : shared, "deg", 0.0, static_cast<int>(i), 3});
  }
  return angles;
}

void judge_baselines(std::vector<LogEntry>& entries, const Dataset& training, const Dataset& judged,
                     const LogSchema& schema, const std::vector<AnglePair>& angles, const EvaluationWindows& windows,
                     const std::function<bool(const std::string& name)>& wanted) {
  for (const std::string& name : LogBaseline::names()) {
    if (!wanted(name)) continue;
    const LogBaseline baseline = LogBaseline::fit(name, training, schema.state_sources);
    std::vector<std::string> describe;
    for (int i = 0; i < static_cast<int>(judged.states.size()); ++i)
      describe.push_back(baseline.applies(i) ? baseline.describe(i) : "");
    if (std::ranges::all_of(describe, &std::string::empty)) continue;
    std::vector<Eigen::MatrixXd> estimates;
    for (const Trajectory& run : judged.trajectories) estimates.push_back(baseline.estimate(run));
    entries.push_back({name,
                       std::move(describe),
                       log_metrics(judged, estimates, angles, windows),
                       {static_cast<double>(baseline.multiply_adds()), 0.0}});
  }
}

LogEvaluation evaluate_on_logs(const codegen::Model& model, const Dataset& logs, const LogSchema& schema,
                               const Dataset* baseline_logs, const NoiseConfig& noise, std::uint64_t seed,
                               MetricsConfig config, const StudyProgress& progress, const LogFlight& flight) {
  if (logs.trajectories.empty()) throw Error("evaluation: there is no log; name at least one");
  require_same_names(model.outputs, logs.outputs, "outputs");
  const std::vector<Eigen::Index> scored = scored_states(model, logs);
  if (!model.inputs.empty()) require_same_names(model.inputs, logs.inputs, "inputs");
  const auto say = [&](double share, const std::string& what) {
    if (progress) progress(share, what);
  };

  LogEvaluation result;
  result.noise = noise;
  result.seed = seed;
  result.states = logs.states;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(model.states.size()); ++i)
    if (std::find(scored.begin(), scored.end(), i) == scored.end())
      result.unscored_states.push_back(model.states[static_cast<std::size_t>(i)].name);
  result.outputs = logs.outputs;
  result.baselines_fitted_on = baseline_logs ? "the training logs" : "these logs, in hindsight";
  result.unscored = find_unscored(logs);
  if (!share_a_unit(logs.states)) config.state_scale = state_deviation(logs);

  const Dataset measured = with_faults(with_empty_cells(with_noise(logs, noise, seed)), flight.faults);
  for (const SensorFault& fault : flight.faults) result.missing.push_back(format_fault(fault));
  const std::vector<SensorFault> told = missing_alone(flight.faults);
  result.behind_gate = flight.behind_gate;
  const std::vector<AnglePair> angles = angles_of(schema, model, scored.size());
  const auto judge = [&](const std::string& name, std::vector<std::string> describe,
                         const std::vector<Eigen::MatrixXd>& estimates) {
    result.entries.push_back({name, std::move(describe), log_metrics(logs, estimates, angles, config.windows)});
  };

  // One run of the observer gives its estimates and the inputs of the linear readout.
  std::optional<codegen::Gate> gate;
  if (flight.behind_gate)
    gate = codegen::Gate::kUsed;
  else if (model.error && model.monitor)
    gate = codegen::Gate::kNotUsed;  // the monitor also gives the widened intervals
  const ObserverRun observer = observer_run(model, has_uniform_steps(logs, model), gate);
  std::vector<codegen::Run> runs;
  std::vector<Eigen::MatrixXd> estimates;
  ErrorAccumulator sum(logs.states, logs.sample_period_s, config);
  CoverageSum covered(logs.states), widened(logs.states);
  std::vector<double> errors;
  const Eigen::VectorXd scale = state_deviation(logs);
  const auto count = static_cast<double>(logs.trajectories.size());
  for (std::size_t i = 0; i < logs.trajectories.size(); ++i) {
    const Trajectory& run = measured.trajectories[i];
    say(0.3 * static_cast<double>(i) / count, "observer on " + run.source);
    runs.push_back(observer(run.outputs, run.inputs, run.time_s));
    estimates.emplace_back(runs.back().x_hat(scored, Eigen::all));
    count_domain(runs.back(), result.domain);
    sum.add(logs.trajectories[i], estimates.back());
    const auto cover = [&](CoverageSum& sum_of, const Estimates& all) {
      sum_of.add(logs.trajectories[i],
                 {all.x_hat(scored, Eigen::all), all.sigma(scored, Eigen::all), all.bound_95(scored, Eigen::all)});
    };
    if (model.error) cover(covered, estimates_of(model, runs.back()));
    if (model.error && model.monitor) cover(widened, widened_estimates_of(model, runs.back()));
    errors.push_back(relative_error(logs.trajectories[i], estimates.back(), logs.states, scale));
  }
  judge("observer", {}, estimates);
  result.metrics = sum.metrics();
  result.coverage = covered.coverage();
  result.widened_coverage = widened.coverage();
  for (const Chosen& chosen : spread_choice(errors)) {
    const std::size_t i = chosen.run;
    result.examples.push_back({logs.trajectories[i], measured.trajectories[i].outputs, estimates[i], chosen.why});
    result.examples.back().all_estimates = runs[i].x_hat;
    result.examples.back().outside = outside_of_domain(model, result.examples.back(), has_uniform_steps(logs, model));
  }
  const std::vector<std::string> senseless = unscored_notes(logs, estimates);

  // The baselines get the same noise as the observer, with separate draws for the fit.
  const Dataset fitted_on =
      with_faults(with_empty_cells(with_noise(baseline_logs ? *baseline_logs : logs, noise, seed + 1)), told);
  double share = 0.3;
  judge_baselines(result.entries, held(fitted_on), held(measured), schema, angles, config.windows,
                  [&](const std::string& name) {
                    say(std::exchange(share, share + 0.1), name);
                    return told.empty() || name == "constant";
                  });

  say(0.8, "ridge");
  LinearReadout readout(model, logs.states, settled_from_s(config.windows));
  const ObserverRun on_training = observer_run(model, has_uniform_steps(fitted_on, model));
  for (const Trajectory& run : fitted_on.trajectories)
    readout.add(on_training(run.outputs, run.inputs, run.time_s), run);
  readout.fit();
  estimates.clear();
  for (const codegen::Run& run : runs) estimates.push_back(readout.estimate(run));
  judge("ridge", std::vector<std::string>(logs.states.size(), "ridge on the same features"), estimates);
  say(1.0, "done");

  result.notes = compared(result.entries);
  result.notes.insert(result.notes.end(), senseless.begin(), senseless.end());
  return result;
}

}  // namespace nlo::trainer
