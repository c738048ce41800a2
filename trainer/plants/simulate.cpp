// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "codegen/base/error.h"
#include "codegen/reference/rk4.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

constexpr double kEscape = 1e9;  // far beyond the useful range of any plant, far below overflow in RK4

}  // namespace

void refuse_escape(const Plant& plant, const std::vector<codegen::Channel>& channels, const Eigen::MatrixXd& x,
                   const Eigen::MatrixXd& initial, double time_s) {
  const Eigen::Index column = first_escaped(x);
  if (column < 0) return;
  Eigen::Index row = 0;
  while (std::abs(x(row, column)) <= kEscape) ++row;
  throw codegen::Error(
      fmt::format("plant {}: {} of the trajectory from x(0) = ({}) is not finite or exceeds 1e9 at t = {:.6g} s; make "
                  "the initial box or the horizon smaller, or the sample period shorter{}",
                  plant.name(), channels[static_cast<std::size_t>(row)].name, fmt::join(initial.col(column), ", "),
                  time_s, plant.nu() > 0 ? ", or stabilise the plant by a [feedback]" : ""));
}

Eigen::Index first_escaped(const Eigen::MatrixXd& x) {
  if ((x.array().abs() <= kEscape).all()) return -1;
  for (Eigen::Index column = 0; column < x.cols(); ++column)
    if (!(x.col(column).array().abs() <= kEscape).all()) return column;
  return -1;
}

Eigen::MatrixXd driven_derivative(const Plant& plant, const Eigen::MatrixXd& x, const Eigen::VectorXd& u) {
  if (u.size() == 0) return plant.derivative(x);
  return plant.driven_derivative(x, u.replicate(1, x.cols()));
}

Eigen::MatrixXd rk4_step(const Plant& plant, const Eigen::MatrixXd& x, double h, const Excitation& excitation,
                         double time_s) {
  const auto u = [&](double at) { return excitation ? excitation(at) : Eigen::VectorXd(); };
  const Eigen::VectorXd middle = u(time_s + 0.5 * h);
  return codegen::rk4_step(x, h, [&](double c, const Eigen::MatrixXd& at) {
    return driven_derivative(plant, at, c == 0.5 ? middle : u(time_s + c * h));
  });
}

Eigen::Index sample_count(const SimulationConfig& config) {
  // A horizon that is a whole number of periods up to rounding includes its last sample.
  constexpr double kRounding = 1e-9;
  return static_cast<Eigen::Index>(std::floor(config.horizon_s / config.sample_period_s + kRounding)) + 1;
}

void unwrap_outputs(Dataset& dataset) {
  for (std::size_t j = 0; j < dataset.outputs.size(); ++j) {
    const double wrap = dataset.outputs[j].wrap;
    if (wrap <= 0.0) continue;
    for (Trajectory& run : dataset.trajectories) {
      auto row = run.outputs.row(static_cast<Eigen::Index>(j));
      row = unwrap(row.transpose(), wrap).transpose();
    }
  }
}

Dataset empty_runs(const Plant& plant, const SimulationConfig& config, Eigen::Index count) {
  const Eigen::Index samples = sample_count(config);
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
  return dataset;
}

Dataset simulate_from(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial,
                      const Excitation& excitation) {
  const Eigen::Index samples = sample_count(config), count = initial.cols();
  const double h = config.sample_period_s;
  Dataset dataset = empty_runs(plant, config, count);
  if (excitation) {
    dataset.inputs = plant.inputs();
    for (Trajectory& run : dataset.trajectories) run.inputs.resize(plant.nu(), samples);
  }
  Eigen::MatrixXd x = initial;
  for (Eigen::Index k = 0;; ++k) {
    const double t = static_cast<double>(k) * h;
    const Eigen::MatrixXd y = plant.output(x);
    refuse_escape(plant, plant.states(), x, initial, t);
    refuse_escape(plant, plant.outputs(), y, initial, t);
    const Eigen::VectorXd u = excitation ? excitation(t) : Eigen::VectorXd();
    for (Eigen::Index i = 0; i < count; ++i) {
      Trajectory& run = dataset.trajectories[static_cast<std::size_t>(i)];
      run.states.col(k) = x.col(i);
      run.outputs.col(k) = y.col(i);
      if (excitation) run.inputs.col(k) = u;
    }
    if (k + 1 == samples) break;
    x = rk4_step(plant, x, h, excitation, t);
  }
  unwrap_outputs(dataset);
  return dataset;
}

Dataset simulate(const Plant& plant, const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                 double box_scale, const Excitation& excitation) {
  return simulate_from(plant, config, draw_initial_states(config, engine_seed, count, box_scale), excitation);
}

}  // namespace nlo::trainer
