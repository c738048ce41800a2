// SPDX-License-Identifier: MIT
#include "trainer/plants/lead_in.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/data/transient.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void fail(const Plant& plant, const Eigen::VectorXd& initial, double t, std::string_view what) {
  throw codegen::Error(
      fmt::format("plant {}: backwards from x(0) = ({}) the trajectory {} at t = {:.6g} s, so transient = \"backward\" "
                  "cannot simulate the past; use \"drop\", or a smaller initial box",
                  plant.name(), fmt::join(initial, ", "), what, t));
}

/// Returns the largest |x_i| of each state over all trajectories.
Eigen::VectorXd ranges(const Dataset& dataset, Eigen::Index nx) {
  Eigen::VectorXd range = Eigen::VectorXd::Zero(nx);
  for (const Trajectory& run : dataset.trajectories) range = range.cwiseMax(run.states.cwiseAbs().rowwise().maxCoeff());
  return range;
}

/// Inserts `past` (samples at t = -n h ... -h) before the samples of `run`.
void prepend(const Eigen::MatrixXd& past_states, const Eigen::MatrixXd& past_outputs, double h, Trajectory& run) {
  const Eigen::Index n = past_states.cols(), samples = n + run.samples();
  const auto joined = [&](const Eigen::MatrixXd& past, const Eigen::MatrixXd& rest) {
    Eigen::MatrixXd all(past.rows(), samples);
    all << past, rest;
    return all;
  };
  run.states = joined(past_states, run.states);
  run.outputs = joined(past_outputs, run.outputs);
  const double first = -static_cast<double>(n);
  run.time_s = joined(Eigen::RowVectorXd::LinSpaced(n, first, -1.0) * h, run.time_s.transpose()).transpose();
  run.weight = joined(Eigen::RowVectorXd::Zero(n), run.weight.transpose()).transpose();
  run.first_estimate += n;
}

}  // namespace

void add_lead_in(const Plant& plant, double transient_s, double factor, Dataset& dataset) {
  const double h = dataset.sample_period_s;
  const auto n = static_cast<Eigen::Index>(std::ceil(transient_s / h - 1e-9));
  const auto count = static_cast<Eigen::Index>(dataset.trajectories.size());
  if (n < 1 || count < 1) return;

  Eigen::MatrixXd initial(plant.nx(), count);
  for (Eigen::Index i = 0; i < count; ++i)
    initial.col(i) = dataset.trajectories[static_cast<std::size_t>(i)].states.col(0);
  std::vector<Eigen::MatrixXd> states(static_cast<std::size_t>(count), Eigen::MatrixXd(plant.nx(), n));
  std::vector<Eigen::MatrixXd> outputs(static_cast<std::size_t>(count), Eigen::MatrixXd(plant.ny(), n));
  Eigen::MatrixXd x = initial;
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    x = rk4_step(plant, x, -h);
    const Eigen::MatrixXd y = plant.output(x);
    const double t = static_cast<double>(k - n) * h;
    for (const Eigen::Index escaped : {first_escaped(x), first_escaped(y)})
      if (escaped >= 0) fail(plant, initial.col(escaped), t, "is not finite or exceeds 1e9");
    for (Eigen::Index i = 0; i < count; ++i) {
      states[static_cast<std::size_t>(i)].col(k) = x.col(i);
      outputs[static_cast<std::size_t>(i)].col(k) = y.col(i);
    }
  }

  // At t = 0 the start of the filter still has the effect exp(-k) T(x(-t_c)). This effect is not small if the plant
  // grows by exp(k) on its way back to -t_c.
  const Eigen::VectorXd most = std::exp(factor) * ranges(dataset, plant.nx());
  for (Eigen::Index i = 0; i < count; ++i)
    if ((x.col(i).array().abs() > most.array()).any())
      fail(plant, initial.col(i), -static_cast<double>(n) * h, "grows faster than the filter forgets");
  for (std::size_t i = 0; i < states.size(); ++i) prepend(states[i], outputs[i], h, dataset.trajectories[i]);
  unwrap_outputs(dataset);
}

void keep_out_transient(const Experiment& experiment, const Plant& plant, Dataset& dataset) {
  const TrainingConfig& training = experiment.training;
  const double transient_s = transient_time_s(experiment.observer, training.transient_factor);
  if (training.transient == Transient::kDrop) drop_transient(dataset, transient_s);
  if (training.transient == Transient::kBackward) add_lead_in(plant, transient_s, training.transient_factor, dataset);
}

}  // namespace nlo::trainer
