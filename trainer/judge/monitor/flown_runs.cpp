// SPDX-License-Identifier: MIT
#include "trainer/judge/monitor/flown_runs.h"

#include <nlo/monitor_model.h>

#include <algorithm>
#include <cmath>

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

FlownRun flown(const Trajectory& truth, const MatrixXd& outputs, bool uniform, Index most) {
  const Index samples = std::min(most, outputs.cols());
  FlownRun run{outputs.leftCols(samples), truth.inputs, truth.states.leftCols(samples), VectorXd::Ones(samples), {}};
  if (truth.inputs.size() > 0) run.inputs = truth.inputs.leftCols(samples);
  if (truth.weight.size() > 0) run.weight = truth.weight.head(samples);
  run.weight.head(std::min(samples, truth.first_estimate)).setZero();
  if (!uniform) run.time_s = truth.time_s.head(samples);
  return run;
}

}  // namespace

FlownRun FlownRun::from(Index first) const {
  const Index rest = samples() - first;
  FlownRun run{outputs.rightCols(rest), inputs, states.rightCols(rest), weight.tail(rest), time_s};
  if (inputs.size() > 0) run.inputs = inputs.rightCols(rest);
  if (time_s.size() > 0) run.time_s = time_s.tail(rest);
  return run;
}

std::vector<FlownRun> flown_runs(const ComparedRuns& runs, Index most) {
  std::vector<FlownRun> all;
  for (std::size_t i = 0; i < runs.outputs.size(); ++i)
    all.push_back(flown(runs.set.trajectories[i], runs.outputs[i], true, most));
  return all;
}

std::vector<FlownRun> flown_runs(const Dataset& logs, Index most) {
  std::vector<FlownRun> all;
  for (const Trajectory& run : logs.trajectories) all.push_back(flown(run, run.measured(), logs.uniform, most));
  return all;
}

VectorXd state_deviations(const std::vector<FlownRun>& runs) {
  const Index nx = runs.front().states.rows();
  VectorXd sum = VectorXd::Zero(nx), squares = VectorXd::Zero(nx);
  double count = 0.0;
  for (const FlownRun& run : runs)
    for (Index k = 0; k < run.samples(); ++k) {
      if (run.weight(k) == 0.0 || !run.states.col(k).allFinite()) continue;
      sum += run.states.col(k);
      squares += run.states.col(k).cwiseAbs2();
      count += 1.0;
    }
  if (count == 0.0) return VectorXd::Ones(nx);
  const VectorXd mean = sum / count;
  const VectorXd variance = (squares / count - mean.cwiseAbs2()).cwiseMax(0.0);
  // A state that does not move has no deviation; its errors are not scaled.
  return variance.cwiseSqrt().unaryExpr([](double d) { return d > 0.0 ? d : 1.0; });
}

double ErrorSum::rms() const {
  return weight > 0.0 ? std::sqrt(squares / weight) : 0.0;
}

ErrorSum& ErrorSum::operator+=(const ErrorSum& other) {
  squares += other.squares;
  weight += other.weight;
  return *this;
}

ErrorSum error_sum(const codegen::Model& model, const FlownRun& run, const MatrixXd& x_hat, const VectorXd& deviations,
                   Index first, Index end) {
  ErrorSum sum;
  for (Index k = first; k < std::min(end, run.samples()); ++k) {
    if (run.weight(k) == 0.0 || !run.states.col(k).allFinite()) continue;
    for (Index i = 0; i < run.states.rows(); ++i) {
      const double turn = model.states[static_cast<std::size_t>(i)].wrap;
      const double off = x_hat(i, k) - run.states(i, k);
      sum.squares += std::pow((turn > 0.0 ? std::remainder(off, turn) : off) / deviations(i), 2);
    }
    sum.weight += 1.0;
  }
  return sum;
}

codegen::WatchedRun fly(const codegen::Model& model, const codegen::Monitor& monitor, const FlownRun& run) {
  return codegen::watched_run(model, monitor, run.outputs, run.inputs, run.time_s);
}

codegen::Monitor without_gate(codegen::Monitor monitor) {
  monitor.gate = std::sqrt(kNoLimit);
  codegen::leave_out_frozen(monitor, monitor.deviation.size());
  return monitor;
}

}  // namespace nlo::trainer
