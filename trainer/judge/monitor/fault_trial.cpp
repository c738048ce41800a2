// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/fault_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "trainer/base/quantile.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::array<Fault, 5> kFaults = {Fault::kDead, Fault::kFrozen, Fault::kZero, Fault::kBiased, Fault::kNoisy};
constexpr double kBias = 0.5, kNoise = 2.0;  // deviations of the output
constexpr double kHarm = 2.0;
constexpr double kUndetected = 0.1;  // largest share of harmed runs without an alarm

VectorXd output_deviations(const std::vector<FlownRun>& runs) {
  const Index ny = runs.front().outputs.rows();
  VectorXd sum = VectorXd::Zero(ny), squares = VectorXd::Zero(ny), count = VectorXd::Zero(ny);
  for (const FlownRun& run : runs)
    for (Index k = 0; k < run.samples(); ++k)
      for (Index j = 0; j < ny; ++j) {
        const double y = run.outputs(j, k);
        if (!std::isfinite(y)) continue;
        sum(j) += y;
        squares(j) += y * y;
        count(j) += 1.0;
      }
  count = count.cwiseMax(1.0);
  return (squares.cwiseQuotient(count) - sum.cwiseQuotient(count).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
}

double uniform01(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11U) * 0x1p-53;
}

/// Returns the run with a fault of output j from sample `first` on. `slow`: the output has a period of its own and
/// sends nothing between its samples.
FlownRun with_fault(FlownRun run, Fault fault, Index j, bool slow, Index first, double deviation, std::size_t number) {
  double last = 0.0;
  for (Index k = 0; k < first; ++k)
    if (std::isfinite(run.outputs(j, k))) last = run.outputs(j, k);
  std::mt19937_64 engine(0x6661756cULL + number);
  for (Index k = first; k < run.samples(); ++k) {
    double& y = run.outputs(j, k);
    if (slow && !std::isfinite(y)) continue;
    switch (fault) {
      case Fault::kDead:
        y = std::numeric_limits<double>::quiet_NaN();
        break;
      case Fault::kFrozen:
        y = last;
        break;
      case Fault::kZero:
        y = 0.0;
        break;
      case Fault::kBiased:
        y += kBias * deviation;
        break;
      case Fault::kNoisy:
        y += kNoise * deviation * std::sqrt(3.0) * (2.0 * uniform01(engine) - 1.0);
        break;
    }
  }
  return run;
}

struct Outcome {
  ErrorSum sound, faulty;
  Index delay = -1;  ///< samples from the fault to the first alarm; -1: none
  nlo::Alarm alarm = nlo::Alarm::kNone;
};

}  // namespace

const char* fault_name(Fault fault) {
  constexpr std::array<const char*, 5> kNames = {"dead", "frozen", "zero", "biased", "noisy"};
  return kNames[static_cast<std::size_t>(fault)];
}

bool FaultRow::undetected() const {
  return fault <= Fault::kZero && static_cast<double>(harmed - seen) > kUndetected * static_cast<double>(harmed);
}

std::vector<FaultRow> try_faults(const codegen::Model& model, const codegen::Monitor& monitor,
                                 const std::vector<FlownRun>& runs, ThreadPool& pool) {
  std::vector<FaultRow> rows;
  if (runs.empty()) return rows;
  const VectorXd states = state_deviations(runs), outputs = output_deviations(runs);
  // If there are few logs, each is run several times with the fault at different times, because a frozen sensor does no
  // harm at rest.
  constexpr std::size_t kFlights = 12;
  const std::size_t times = std::max<std::size_t>(1, kFlights / runs.size());
  const std::size_t flights = times * runs.size();
  const auto run_of = [&](std::size_t flight) -> const FlownRun& { return runs[flight / times]; };
  const auto begins = [&](std::size_t flight) {
    if (times == 1) return run_of(flight).samples() / 2;
    const double share = 0.1 + 0.6 * static_cast<double>(flight % times) / static_cast<double>(times - 1);
    return static_cast<Index>(share * static_cast<double>(run_of(flight).samples()));
  };
  std::vector<ErrorSum> sound(flights);
  pool.run(static_cast<int>(flights), [&](int index, int) {
    const auto i = static_cast<std::size_t>(index);
    sound[i] = error_sum(model, run_of(i), fly(model, monitor, run_of(i)).run.x_hat, states, begins(i));
  });
  for (Index j = 0; j < model.measured(); ++j)
    for (const Fault fault : kFaults) {
      const bool slow = model.outputs[static_cast<std::size_t>(j)].period_s > 0.0;
      std::vector<Outcome> outcomes(flights);
      pool.run(static_cast<int>(flights), [&](int index, int) {
        const auto i = static_cast<std::size_t>(index);
        const Index first = begins(i);
        const codegen::WatchedRun watched =
            fly(model, monitor, with_fault(run_of(i), fault, j, slow, first, outputs(j), i));
        Outcome& outcome = outcomes[i];
        outcome.sound = sound[i];
        outcome.faulty = error_sum(model, run_of(i), watched.run.x_hat, states, first);
        for (Index k = first; k < run_of(i).samples() && outcome.delay < 0; ++k)
          if (const nlo::Alarm alarm = watched.alarms[static_cast<std::size_t>(k)]; alarm != nlo::Alarm::kNone)
            outcome.delay = k - first, outcome.alarm = alarm;
      });
      FaultRow row;
      row.output = model.outputs[static_cast<std::size_t>(j)].name;
      row.fault = fault;
      ErrorSum all, without;
      std::vector<double> delays;
      std::map<nlo::Alarm, int> alarms;
      for (const Outcome& outcome : outcomes) {
        all += outcome.faulty;
        without += outcome.sound;
        const bool harmed = outcome.faulty.rms() > kHarm * outcome.sound.rms();
        row.harmed += harmed;
        if (!harmed || outcome.delay < 0) continue;
        ++row.seen;
        delays.push_back(static_cast<double>(outcome.delay) * model.sample_period_s);
        ++alarms[outcome.alarm];
      }
      row.error = without.rms() > 0.0 ? all.rms() / without.rms() : 1.0;
      if (!delays.empty()) row.median_delay_s = value_at_rank(delays, 0.5);
      int most = 0;
      for (const auto& [alarm, count] : alarms)
        if (count > most) most = count, row.most = alarm;
      rows.push_back(row);
    }
  return rows;
}

}  // namespace nlo::trainer
