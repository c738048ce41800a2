// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/gate_trial.h"

#include <fmt/format.h>
#include <nlo/monitor_model.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "codegen/fold/fold.h"

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct WayToFly {
  const char* when;
  std::vector<FlownRun> runs;
};

MatrixXd beside(const MatrixXd& left, const MatrixXd& right) {
  if (left.size() == 0) return left;
  MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

/// Joins `head` samples of one run and `tail`, with `pause_s` between their time stamps. Without `timed`, every step is
/// one sample period.
FlownRun joined(const FlownRun& head, Index count, const FlownRun& tail, double pause_s, double period_s, bool timed) {
  FlownRun run;
  run.outputs = beside(head.outputs.leftCols(count), tail.outputs);
  run.states = beside(head.states.leftCols(count), tail.states);
  if (head.inputs.size() > 0) run.inputs = beside(head.inputs.leftCols(count), tail.inputs);
  run.weight.resize(count + tail.samples());
  run.weight << head.weight.head(count), tail.weight;
  if (!timed && head.time_s.size() == 0) return run;
  const auto stamps = [period_s](const FlownRun& of) -> VectorXd {
    if (of.time_s.size() > 0) return of.time_s;
    return VectorXd::LinSpaced(of.samples(), 0.0, static_cast<double>(of.samples() - 1) * period_s);
  };
  const VectorXd first = stamps(head), second = stamps(tail);
  run.time_s.resize(run.weight.size());
  run.time_s << first.head(count), (second.array() - second(0) + first(count - 1) + pause_s).matrix();
  return run;
}

std::vector<WayToFly> ways_to_fly(const std::vector<FlownRun>& runs, Index gap, double period_s) {
  std::vector<WayToFly> ways = {
      {"as trained", runs}, {"after a restart", {}}, {"after a jump of the state", {}}, {"after a gap", {}}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const FlownRun& run = runs[i];
    const Index half = run.samples() / 2;
    if (half < 2) continue;
    ways[1].runs.push_back(run.from(half));
    const FlownRun& other = runs[(i + 1) % runs.size()];
    if (other.samples() > half) ways[2].runs.push_back(joined(run, half, other.from(half), period_s, period_s, false));
    if (run.samples() > half + gap)
      ways[3].runs.push_back(
          joined(run, half, run.from(half + gap), static_cast<double>(gap + 1) * period_s, period_s, true));
  }
  return ways;
}

/// Returns 1 for each output that is due in every sample, and that the observer does not expect to be missing.
VectorXd replaceable(const codegen::Model& model) {
  VectorXd may = VectorXd::Zero(model.ny());
  const std::vector<int> not_due = codegen::not_due(model);
  for (int j = 0; j < model.measured(); ++j)
    may(j) = not_due[static_cast<std::size_t>(j)] == 0 && !std::ranges::count(model.failures.outputs, j) ? 1.0 : 0.0;
  return may;
}

/// Returns the runs without some of their readings, the same in every call.
std::vector<FlownRun> with_lost_readings(std::vector<FlownRun> runs) {
  constexpr std::uint64_t kOneIn = 50, kLongest = 3;
  std::mt19937_64 engine(0x6c6f7374ULL);
  for (FlownRun& run : runs)
    for (Index j = 0; j < run.outputs.rows(); ++j) {
      std::uint64_t lost = 0;
      for (Index k = 0; k < run.samples(); ++k) {
        if (lost == 0 && engine() % kOneIn == 0) lost = 1 + engine() % kLongest;
        if (lost == 0) continue;
        --lost;
        run.outputs(j, k) = std::numeric_limits<double>::quiet_NaN();
      }
    }
  return runs;
}

double rms(const codegen::Model& model, const Monitor& monitor, const std::vector<FlownRun>& runs,
           const VectorXd& deviations, ThreadPool& pool) {
  std::vector<ErrorSum> sums(runs.size());
  pool.run(static_cast<int>(runs.size()), [&](int index, int) {
    const auto i = static_cast<std::size_t>(index);
    sums[i] = error_sum(model, runs[i], fly(model, monitor, runs[i]).run.x_hat, deviations);
  });
  ErrorSum all;
  for (const ErrorSum& sum : sums) all += sum;
  return all.rms();
}

std::vector<GateTrial> try_gate(const codegen::Model& model, const Monitor& monitor, const std::vector<WayToFly>& ways,
                                const std::vector<double>& plain, const VectorXd& deviations, ThreadPool& pool) {
  std::vector<GateTrial> trials;
  for (std::size_t w = 0; w < ways.size(); ++w)
    trials.push_back({ways[w].when, plain[w], rms(model, monitor, ways[w].runs, deviations, pool)});
  return trials;
}

const GateTrial& worst(const std::vector<GateTrial>& trials) {
  return *std::max_element(trials.begin(), trials.end(),
                           [](const GateTrial& a, const GateTrial& b) { return a.cost() < b.cost(); });
}

}  // namespace

std::optional<GateTrial> replace_lost_readings(const codegen::Model& model, Monitor& monitor,
                                               const std::vector<FlownRun>& runs, ThreadPool& pool) {
  constexpr double kWorthIt = 0.95;
  Monitor replacing = monitor;
  replacing.replaces = replaceable(model);
  if (runs.empty() || !replacing.replaces_any()) return std::nullopt;
  const VectorXd deviations = state_deviations(runs);
  const std::vector<FlownRun> lossy = with_lost_readings(runs);
  const GateTrial trial{"with lost readings", rms(model, monitor, lossy, deviations, pool),
                        rms(model, replacing, lossy, deviations, pool)};
  if (trial.cost() < kWorthIt) monitor.replaces = replacing.replaces;
  return trial;
}

GateReport drop_harmful_gates(const codegen::Model& model, Monitor& monitor, const std::vector<FlownRun>& runs,
                              Index gap, ThreadPool& pool) {
  GateReport report;
  if (runs.empty()) return report;
  const VectorXd deviations = state_deviations(runs);
  const std::vector<WayToFly> ways = ways_to_fly(runs, gap, model.sample_period_s);
  std::vector<double> plain;
  for (const WayToFly& way : ways) plain.push_back(rms(model, without_gate(monitor), way.runs, deviations, pool));

  report.trials = try_gate(model, monitor, ways, plain, deviations, pool);
  if (worst(report.trials).cost() <= kMostGateCost) return report;
  Monitor gate_alone = monitor, frozen_alone = monitor;
  codegen::leave_out_frozen(gate_alone, model.ny());
  frozen_alone.gate = std::sqrt(kNoLimit);
  const auto try_alone = [&](const Monitor& alone, const char* what, const auto& drop) {
    const std::vector<GateTrial> trials = try_gate(model, alone, ways, plain, deviations, pool);
    const GateTrial& most = worst(trials);
    if (most.cost() <= kMostGateCost) return;
    report.dropped.push_back(fmt::format("{} multiplies the error by {:.3g} {}", what, most.cost(), most.when));
    drop();
  };
  if (!monitor.freezes_none())
    try_alone(frozen_alone, "rejecting frozen sensors", [&] { codegen::leave_out_frozen(monitor, model.ny()); });
  try_alone(gate_alone, "rejecting outliers", [&] { monitor.gate = std::sqrt(kNoLimit); });
  if (report.dropped.empty()) {  // each alone is harmless, but both together increase the error
    report.dropped.push_back(fmt::format("rejecting frozen sensors beside the gate multiplies the error by {:.3g} {}",
                                         worst(report.trials).cost(), worst(report.trials).when));
    codegen::leave_out_frozen(monitor, model.ny());
  }
  return report;
}

}  // namespace nlo::trainer
