// SPDX-License-Identifier: MIT
#include "trainer/analysis/evaluate_logs.h"

#include <algorithm>
#include <cmath>

#include "codegen/error.h"
#include "trainer/analysis/examples.h"
#include "trainer/analysis/measurement_noise.h"
#include "trainer/analysis/text.h"
#include "trainer/data/log_baselines.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

Dataset with_noise(Dataset data, const NoiseConfig& noise, std::uint64_t seed) {
  for (std::size_t i = 0; i < data.trajectories.size(); ++i) {
    Eigen::MatrixXd& y = data.trajectories[i].outputs;
    y = MeasurementNoise(noise, seed, i).on(y, data.output_angles);
  }
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

std::vector<std::string> compare_with_constant(const LogMetrics& observer, const LogMetrics& constant) {
  constexpr std::size_t kAfter2s = 1, kAll = 0;
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < observer.pooled.size(); ++i) {
    const StateError& ours = observer.pooled[i];
    // Logs of less than 2 s are judged as a whole.
    const std::size_t window = std::isfinite(ours.rmse[kAfter2s]) ? kAfter2s : kAll;
    const double error = ours.rmse[window], reference = constant.pooled[i].rmse[window];
    if (!std::isfinite(error) || !std::isfinite(reference) || error < kNoBetterThanConstant * reference) continue;
    const std::string unit = ours.unit.empty() ? "" : " " + ours.unit;
    notes.push_back(ours.name + " is not seen: its error " + kErrorWindows[window].name + ", " + significant(error) +
                    unit + ", is no better than that of a constant, " + significant(reference) + unit +
                    ". These outputs may not determine it.");
  }
  return notes;
}

}  // namespace

LogEvaluation evaluate_on_logs(const codegen::Model& model, const Dataset& logs, const LogSchema& schema,
                               const Dataset* baseline_logs, const NoiseConfig& noise, std::uint64_t seed) {
  if (logs.trajectories.empty()) throw Error("evaluation: no log to evaluate on");
  require_same_names(model.outputs, logs.outputs, "outputs");
  require_same_names(model.states, logs.states, "states");

  LogEvaluation result;
  result.noise = noise;
  result.seed = seed;
  result.states = logs.states;
  result.outputs = logs.outputs;
  result.baselines_fitted_on = baseline_logs ? "the training logs" : "these logs";
  result.one_unit = std::all_of(logs.states.begin(), logs.states.end(),
                                [&](const Channel& state) { return state.unit == logs.states.front().unit; });

  const Dataset measured = with_noise(logs, noise, seed);
  const auto judge = [&](const std::string& name, std::vector<std::string> describe,
                         const std::vector<Eigen::MatrixXd>& estimates) {
    result.entries.push_back({name, std::move(describe), log_metrics(logs, estimates, schema.angle_pairs)});
  };

  const Estimator observer = observer_estimator(model, logs.uniform)();
  std::vector<Eigen::MatrixXd> estimates;
  ErrorAccumulator sum(logs.states, logs.sample_period_s);
  std::vector<double> errors;
  const Eigen::VectorXd scale = state_scale(logs);
  for (std::size_t i = 0; i < logs.trajectories.size(); ++i) {
    const Trajectory& run = measured.trajectories[i];
    estimates.push_back(observer(run.outputs, run.inputs, run.time_s));
    sum.add(logs.trajectories[i], estimates.back());
    errors.push_back(relative_error(logs.trajectories[i], estimates.back(), logs.states, scale));
  }
  judge("observer", {}, estimates);
  result.metrics = sum.metrics();
  for (const Chosen& chosen : spread_choice(errors)) {
    const std::size_t i = chosen.run;
    result.examples.push_back({logs.trajectories[i], measured.trajectories[i].outputs, estimates[i], chosen.why});
    result.examples.back().outside = outside_of_domain(model, result.examples.back(), logs.uniform);
  }

  // The baselines see the noise that the observer sees, with draws of their own for fitting.
  const Dataset fitted_on = with_noise(baseline_logs ? *baseline_logs : logs, noise, seed + 1);
  for (const std::string& name : LogBaseline::names()) {
    const LogBaseline baseline = LogBaseline::fit(name, fitted_on, schema.state_sources);
    std::vector<std::string> describe;
    bool applies = false;
    for (int i = 0; i < static_cast<int>(logs.states.size()); ++i) {
      applies = applies || baseline.applies(i);
      describe.push_back(baseline.applies(i) ? baseline.describe(i) : "");
    }
    if (!applies) continue;
    estimates.clear();
    for (const Trajectory& run : measured.trajectories) estimates.push_back(baseline.estimate(run));
    judge(name, std::move(describe), estimates);
    if (name == "constant")
      result.notes = compare_with_constant(result.entries.front().metrics, result.entries.back().metrics);
  }
  return result;
}

}  // namespace nlo::trainer
