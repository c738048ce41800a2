// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/filter_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/dataset.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/filters/filter_bank.h"
#include "trainer/judge/filters/high_gain.h"
#include "trainer/judge/filters/moving_horizon.h"
#include "trainer/judge/filters/plant_equations.h"
#include "trainer/plants/equations_of_plant.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Filter = std::unique_ptr<LaneFilter>;
using Tunings = std::vector<FilterTuning>;

double size(Index n) {
  return static_cast<double>(n);
}

std::string always_fit(const FilterContext&) {
  return "";
}

// ---- Tuned factors

TunedFactor factor_on(std::string name, double FilterTuning::*number, std::vector<double> decades = {0.0}) {
  return {std::move(name), [number](FilterTuning& t, double factor) { t.*number = factor; }, std::move(decades)};
}

TunedFactor factor_of_state(std::string name, std::vector<double> FilterTuning::*numbers, Index nx, Index first,
                            Index count) {
  return {std::move(name), [=](FilterTuning& t, double factor) {
            (t.*numbers).resize(static_cast<std::size_t>(nx), 1.0);
            std::fill_n((t.*numbers).begin() + first, count, factor);
          }};
}

TunedFactor process_factor() {
  return factor_on("Q", &FilterTuning::process, {0.0, 2.0, 4.0});
}

std::vector<TunedFactor> only_process(const FilterContext&) {
  return {process_factor()};
}

std::vector<TunedFactor> process_and_output(const FilterContext&) {
  return {process_factor(), factor_on("R", &FilterTuning::output, {0.0, -1.0, 1.0})};
}

/// Returns factors for Q, R and P0 as a whole, then for Q state by state, because an error of the plant may be in a
/// single equation. The last `further` states are parameters with their own drift and prior.
std::vector<TunedFactor> covariances(const FilterContext& c, Index further) {
  std::vector<TunedFactor> factors = process_and_output(c);
  factors.push_back(factor_on("P0", &FilterTuning::initial));
  const Index nx = c.plant.nx + further;
  for (Index i = 0; i < c.plant.nx && c.plant.nx > 1; ++i)
    factors.push_back(
        factor_of_state("Q of " + c.states[static_cast<std::size_t>(i)], &FilterTuning::process_of, nx, i, 1));
  if (further == 0) return factors;
  factors.push_back(factor_of_state("drift", &FilterTuning::process_of, nx, c.plant.nx, further));
  factors.push_back(factor_of_state("prior", &FilterTuning::initial_of, nx, c.plant.nx, further));
  return factors;
}

std::vector<TunedFactor> covariances_of_states(const FilterContext& c) {
  return covariances(c, 0);
}

std::vector<TunedFactor> covariances_of_all(const FilterContext& c) {
  return covariances(c, static_cast<Index>(c.joint_parameters.size()));
}

// ---- EKF and UKF

template <PointSet kPoints>
Filter sigma_points(const FilterContext& c, const Tunings& tunings, Index lanes) {
  return std::make_unique<SigmaPointFilter>(c.plant, kPoints, c.knowledge, tunings, lanes);
}

template <PointSet kPoints>
StepCost cost_of_sigma_points(const FilterContext& c, const PlantCost& plant) {
  return sigma_point_cost(size(c.plant.nx), size(c.plant.ny), kPoints == PointSet::kExtended, plant);
}

Index root_state(const FilterContext& c) {
  return c.plant.nx + c.plant.nx * (c.plant.nx + 1) / 2;
}

// ---- A bank of EKFs

Filter ekf_bank(const FilterContext& c, const Tunings& tunings, Index lanes) {
  FilterKnowledge of_one = c.knowledge;
  // The K boxes together fill the box of all initial states, so each filter starts with a smaller P0.
  of_one.initial_covariance *= std::pow(size(c.initial.cols()), -2.0 / size(c.plant.nx));
  return std::make_unique<FilterBank>(c.plant, PointSet::kExtended, of_one, c.initial, tunings, lanes);
}

StepCost cost_of_bank(const FilterContext& c, const PlantCost& plant) {
  return bank_cost(size(c.initial.cols()), size(c.plant.nx), size(c.plant.ny),
                   cost_of_sigma_points<PointSet::kExtended>(c, plant));
}

Index bank_state(const FilterContext& c) {
  return c.initial.cols() * (root_state(c) + 1);
}

// ---- The EKF that also estimates parameters

constexpr double kParameterDeviation = 0.2;  // relative to the nominal value, as in a data sheet
constexpr double kParameterDrift = 1e-4;     // relative to the nominal value, per step
constexpr double kFarParameter = 10.0;       // times the nominal value; beyond it the filter is lost

std::string joint_unfit(const FilterContext& c) {
  return c.joint_parameters.empty() ? "no condition changes a parameter" : "";
}

Filter joint_ekf(const FilterContext& c, const Tunings& tunings, Index lanes) {
  const auto np = static_cast<Index>(c.joint_parameters.size());
  const LanePlant joint = joint_plant(c.config, c.joint_parameters, c.initial);
  FilterKnowledge known = c.knowledge;
  for (Eigen::VectorXd* values : {&known.initial_state, &known.process_deviation, &known.farthest})
    values->conservativeResize(c.plant.nx + np);
  known.initial_covariance = Eigen::MatrixXd::Zero(c.plant.nx + np, c.plant.nx + np);
  known.initial_covariance.topLeftCorner(c.plant.nx, c.plant.nx) = c.knowledge.initial_covariance;
  const PlantParameters nominal = equations_of(c.config).parameters;
  for (Index i = 0; i < np; ++i) {
    double value = 0.0;
    for (const auto& [name, given] : nominal)
      if (name == c.joint_parameters[static_cast<std::size_t>(i)]) value = given;
    const double unit = value != 0.0 ? std::abs(value) : 1.0;
    known.initial_state[c.plant.nx + i] = value;
    known.initial_covariance(c.plant.nx + i, c.plant.nx + i) = std::pow(kParameterDeviation * unit, 2);
    known.process_deviation[c.plant.nx + i] = kParameterDrift * unit;
    known.farthest[c.plant.nx + i] = kFarParameter * unit;
  }
  return std::make_unique<SigmaPointFilter>(joint, PointSet::kExtended, known, tunings, lanes);
}

StepCost cost_of_joint(const FilterContext& c, const PlantCost& plant) {
  return sigma_point_cost(size(c.plant.nx) + static_cast<double>(c.joint_parameters.size()), size(c.plant.ny), true,
                          plant);
}

Index joint_state(const FilterContext& c) {
  const Index n = c.plant.nx + static_cast<Index>(c.joint_parameters.size());
  return n + n * (n + 1) / 2;
}

// ---- Moving horizon

Filter moving_horizon(const FilterContext& c, const Tunings& tunings, Index lanes) {
  return std::make_unique<MovingHorizonFilter>(c.plant, c.knowledge, tunings, lanes, kHorizonSamples);
}

StepCost cost_of_horizon(const FilterContext& c, const PlantCost& plant) {
  const double n = size(c.plant.nx), ny = size(c.plant.ny), window = size(kHorizonSamples);
  StepCost cost = sigma_point_cost(n, ny, true, plant);  // cost of the filter that gives the arrival cost
  cost = cost + (rk4_cost(n, plant.f) + plant.h) * (window * (n + 1.0)) + rk4_cost(n, plant.f);
  cost.operations += window * ny * (8.0 + 4.0 * n + 1.5 * n * (n + 1.0)) + n * n * n / 3.0 + 8.0 * n * n;
  cost.functions += n;
  return cost;
}

Index horizon_state(const FilterContext& c) {
  return root_state(c) + c.plant.nx + kHorizonSamples * (c.plant.ny + c.inputs);
}

// ---- High gain

std::string high_gain_unfit(const FilterContext& c) {
  return no_high_gain(c.plant.nx, c.plant.ny, c.inputs);
}

Filter high_gain(const FilterContext& c, const Tunings& tunings, Index lanes) {
  return std::make_unique<HighGainObserver>(c.plant, c.knowledge, tunings, lanes, c.sample_period_s);
}

StepCost cost_of_high_gain(const FilterContext& c, const PlantCost& plant) {
  const double n = size(c.plant.nx), points = 2.0 * n + 1.0;
  StepCost cost =
      rk4_cost(n, plant.f) * (1.0 + (n > 1.0 ? 2.0 * points : 0.0)) + plant.h * (points * (n > 1.0 ? 3.0 : 1.0));
  cost.operations += points * 5.0 + 2.0 * n * n + 2.0 * n * n * n / 3.0 + 3.0 * n * n + n;
  return cost;
}

Index one_number_each(const FilterContext& c) {
  return c.plant.nx;
}

}  // namespace

std::span<const FilterRow> filter_table() {
  static const FilterRow kRows[] = {
      {"ekf", covariances_of_states, true, 3, always_fit, sigma_points<PointSet::kExtended>,
       cost_of_sigma_points<PointSet::kExtended>, root_state},
      {"ukf", covariances_of_states, true, 3, always_fit, sigma_points<PointSet::kUnscented>,
       cost_of_sigma_points<PointSet::kUnscented>, root_state},
      {"ekf_bank", covariances_of_states, true, 1, always_fit, ekf_bank, cost_of_bank, bank_state},
      {"joint_ekf", covariances_of_all, true, 3, joint_unfit, joint_ekf, cost_of_joint, joint_state},
      {"mhe", process_and_output, true, 1, always_fit, moving_horizon, cost_of_horizon, horizon_state},
      {"high_gain", only_process, false, 3, high_gain_unfit, high_gain, cost_of_high_gain, one_number_each},
  };
  return kRows;
}

const FilterRow* find_filter(std::string_view name) {
  for (const FilterRow& row : filter_table())
    if (row.name == name) return &row;
  return nullptr;
}

std::vector<std::string> filter_names() {
  std::vector<std::string> names;
  for (const FilterRow& row : filter_table()) names.emplace_back(row.name);
  return names;
}

FilterContext filter_context(const Experiment& nominal, const NoiseConfig& noise,
                             const std::vector<std::string>& joint_parameters) {
  constexpr double kProcess = 1e-3;      // Q = 1e-6 I
  constexpr double kLeastOutput = 1e-2;  // R >= 1e-4: even without noise a linearisation is not exact
  FilterContext context;
  context.config = *nominal.plant;
  const auto plant = make_plant(*nominal.plant);
  context.states = channel_names(plant->states());
  context.plant = lane_plant(make_plant(*nominal.plant));
  const InitialMoments start = initial_moments(nominal.simulation);
  const Eigen::VectorXd variances = noise_variances(noise);
  const auto& intensity = nominal.simulation.process_noise;
  const Index ny = context.plant.ny;
  context.knowledge = {start.mean,
                       start.covariance,
                       Eigen::VectorXd::Constant(start.mean.size(), kProcess),
                       variances.size() == ny
                           ? Eigen::VectorXd(variances.cwiseSqrt().cwiseMax(kLeastOutput))
                           : Eigen::VectorXd::Constant(ny, std::max(std::sqrt(variances[0]), kLeastOutput)),
                       farthest_states(nominal),
                       Eigen::VectorXd::Map(intensity.data(), static_cast<Index>(intensity.size()))};
  context.joint_parameters = joint_parameters;
  context.initial =
      draw_initial_states(nominal.simulation, initial_state_seed(nominal.seed, SeedStream::kValidation), 8);
  context.sample_period_s = nominal.simulation.sample_period_s;
  context.inputs = nominal.excitation ? plant->nu() : 0;
  return context;
}

}  // namespace nlo::trainer
