// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/sensed_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codegen/structures/structure_module.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {

SensedRuns sensed_runs(const Experiment& experiment, const std::vector<NoiseConfig>& noises, double horizon_s,
                       std::uint64_t seed, int count) {
  Experiment longer = experiment;
  longer.simulation.horizon_s = horizon_s;
  const auto plant = make_plant(*longer.plant);
  const std::uint64_t engine = initial_state_seed(seed, SeedStream::kValidation);
  Dataset set = simulate_runs(longer, *plant, engine, count);
  PlantChannels(*longer.plant, *plant).apply(set);
  SensedRuns runs;
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    const MeasurementNoise noise(noises[i % noises.size()], engine, i);
    runs.outputs.push_back(MeasurementNoise(noise).on(set.trajectories[i].outputs, set.output_angles));
    runs.inputs.push_back(set.trajectories[i].inputs);
  }
  return runs;
}

SensedRuns sensed_runs(const Dataset& logs) {
  SensedRuns runs;
  for (const Trajectory& run : logs.trajectories) {
    runs.outputs.push_back(run.outputs);
    // NaN also if a slow output is not due.
    for (Eigen::Index j = 0; run.missing.size() != 0 && j < run.outputs.rows(); ++j)
      if (logs.outputs[static_cast<std::size_t>(j)].period_s > 0.0) runs.outputs.back().row(j) = run.measured().row(j);
    runs.inputs.push_back(run.inputs);
    if (!logs.uniform) runs.time_s.push_back(run.time_s);
  }
  return runs;
}

namespace {

using Eigen::Index;

/// Returns the correlation time of one output over all runs, in samples. Samples that did not arrive count as the mean.
double correlation_samples(const SensedRuns& runs, Index output) {
  double sum = 0.0, count = 0.0;
  for (const Eigen::MatrixXd& y : runs.outputs)
    for (Index k = 0; k < y.cols(); ++k)
      if (std::isfinite(y(output, k))) sum += y(output, k), count += 1.0;
  const double mean = count > 0.0 ? sum / count : 0.0;
  const auto value = [&](const Eigen::MatrixXd& y, Index k) {
    return std::isfinite(y(output, k)) ? y(output, k) - mean : 0.0;
  };
  const auto product = [&](Index lag) {
    double total = 0.0;
    for (const Eigen::MatrixXd& y : runs.outputs)
      for (Index k = lag; k < y.cols(); ++k) total += value(y, k) * value(y, k - lag);
    return total;
  };
  const double first = product(1);  // normalises by lag 1, because lag 0 contains the noise
  double integral = 0.5;
  for (Index lag = 1; first > 0.0; ++lag) {
    const double share = product(lag) / first;
    if (!(share > 0.0)) break;
    integral += share;
  }
  return integral;
}

constexpr long kLeastSamples = 16;
constexpr double kOfRun = 8.0;             // the longest run must be this many times as long as the period
constexpr std::size_t kEnoughBlocks = 30;  // fewer blocks do not show the tail for a limit

/// Returns the number of whole time constants in `runs`, of `block` samples each, without the first of each run, in
/// which the observer starts.
std::size_t blocks_of(const SensedRuns& runs, Index block) {
  std::size_t blocks = 0;
  for (const Eigen::MatrixXd& y : runs.outputs)
    blocks += static_cast<std::size_t>(std::max<Index>(0, y.cols() / block - 1));
  return blocks;
}

}  // namespace

TimeConstant time_constant(const codegen::Model& model, const SensedRuns& runs, bool recorded) {
  const double period_s = model.sample_period_s, least_s = static_cast<double>(kLeastSamples) * period_s;
  const auto slowest = codegen::module_of(model).slowest_mode(model);
  double own_s = slowest ? 1.0 / *slowest : 0.0;
  if (!slowest) {
    double longest = 0.0;
    for (Index j = 0; j < model.ny(); ++j) longest = std::max(longest, correlation_samples(runs, j));
    own_s = 2.0 * std::numbers::pi * longest * period_s;
  }
  const auto instead = [own_s](double seconds, const std::string& why) {
    return TimeConstant{seconds,
                        fmt::format("averages over {:.3g} s instead of the {:.3g} s of the observer or its outputs: {}",
                                    seconds, own_s, why)};
  };
  if (std::lround(own_s / period_s) < kLeastSamples)
    return instead(least_s, fmt::format("they must span at least {} samples", kLeastSamples));
  TimeConstant chosen{own_s};
  if (!slowest) {
    Index samples = 0;
    for (const Eigen::MatrixXd& y : runs.outputs) samples = std::max(samples, y.cols());
    const double most_s = std::max(least_s, static_cast<double>(samples) * period_s / kOfRun);
    if (own_s > most_s)
      chosen = instead(most_s, fmt::format("the longest run has {:.3g} s", static_cast<double>(samples) * period_s));
  }
  const auto blocks = [&](double seconds) {
    return blocks_of(runs, std::max<Index>(1, std::lround(seconds / period_s)));
  };
  double seconds = chosen.seconds;
  while (recorded && blocks(seconds) < kEnoughBlocks && seconds > least_s) seconds = std::max(least_s, seconds / 2.0);
  if (seconds == chosen.seconds) return chosen;
  return instead(seconds, fmt::format("limits need {} time constants of logs, after the first of each", kEnoughBlocks));
}

}  // namespace nlo::trainer
