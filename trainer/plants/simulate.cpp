// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "codegen/error.h"

namespace nlo::trainer {
namespace {

constexpr double kEscape = 1e9;  // far outside of any plant's useful range, far inside of what RK4 can still compute

void check_finite(const Plant& plant, const Eigen::MatrixXd& x, const Eigen::MatrixXd& initial, double t) {
  const Eigen::Index column = first_escaped(x);
  if (column < 0) return;
  throw codegen::Error(fmt::format(
      "plant {}: the trajectory from x(0) = ({}) is no number or beyond 1e9 at t = {:.6g} s; make the initial box "
      "or the horizon smaller, or the sample period shorter",
      plant.name(), fmt::join(initial.col(column), ", "), t));
}

}  // namespace

Eigen::Index first_escaped(const Eigen::MatrixXd& x) {
  if ((x.array().abs() <= kEscape).all()) return -1;
  for (Eigen::Index column = 0; column < x.cols(); ++column)
    if (!(x.col(column).array().abs() <= kEscape).all()) return column;
  return -1;
}

Eigen::MatrixXd rk4_step(const Plant& plant, const Eigen::MatrixXd& x, double h) {
  const Eigen::MatrixXd k1 = plant.derivative(x);
  const Eigen::MatrixXd k2 = plant.derivative(x + 0.5 * h * k1);
  const Eigen::MatrixXd k3 = plant.derivative(x + 0.5 * h * k2);
  const Eigen::MatrixXd k4 = plant.derivative(x + h * k3);
  return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

Eigen::Index sample_count(const SimulationConfig& config) {
  // A horizon that is a whole number of periods up to rounding keeps its last sample.
  constexpr double kRounding = 1e-9;
  return static_cast<Eigen::Index>(std::floor(config.horizon_s / config.sample_period_s + kRounding)) + 1;
}

Dataset simulate_from(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial) {
  const Eigen::Index samples = sample_count(config), count = initial.cols();
  const double h = config.sample_period_s;
  Dataset dataset;
  dataset.outputs = plant.outputs();
  dataset.states = plant.states();
  dataset.sample_period_s = h;
  dataset.uniform = true;
  dataset.trajectories.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < dataset.trajectories.size(); ++i) {
    Trajectory& run = dataset.trajectories[i];
    run.source = fmt::format("simulation {}", i);
    run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)) * h;
    run.outputs.resize(plant.ny(), samples);
    run.states.resize(plant.nx(), samples);
    run.weight = Eigen::VectorXd::Ones(samples);
  }
  Eigen::MatrixXd x = initial;
  for (Eigen::Index k = 0;; ++k) {
    const Eigen::MatrixXd y = plant.output(x);
    check_finite(plant, x, initial, static_cast<double>(k) * h);
    check_finite(plant, y, initial, static_cast<double>(k) * h);
    for (Eigen::Index i = 0; i < count; ++i) {
      Trajectory& run = dataset.trajectories[static_cast<std::size_t>(i)];
      run.states.col(k) = x.col(i);
      run.outputs.col(k) = y.col(i);
    }
    if (k + 1 == samples) return dataset;
    x = rk4_step(plant, x, h);
  }
}

Dataset simulate(const Plant& plant, const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                 double box_scale) {
  return simulate_from(plant, config, draw_initial_states(config, engine_seed, count, box_scale));
}

}  // namespace nlo::trainer
