// SPDX-License-Identifier: MIT
#include "trainer/prove/robustness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "codegen/model/latent_step.h"
#include "codegen/reference/reference_network.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/base/noise.h"
#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/disturbed_runs.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_form.h"
#include "trainer/prove/lipschitz.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kSlopePoints = 600;
constexpr Index kMostCorners = 16;       // number of states with at most 2^16 corners
constexpr double kTransientShare = 0.1;  // share of the initial error

/// Returns every corner of the box [low, high], n x 2^n.
MatrixXd corners(const VectorXd& low, const VectorXd& high) {
  const Index n = low.size(), count = Index{1} << n;
  MatrixXd result(n, count);
  for (Index c = 0; c < count; ++c)
    for (Index i = 0; i < n; ++i) result(i, c) = (c >> i & 1) != 0 ? high(i) : low(i);
  return result;
}

/// Returns the linearity of the plant: as its class declares it, or else detected from its values at states of the size
/// of `initial`.
Linearity linearity_of(const Plant& plant, const MatrixXd& initial) {
  if (dynamic_cast<const LinearPlant*>(&plant) != nullptr) return {};
  const VectorXd size = initial.cwiseAbs().rowwise().maxCoeff();
  return recognise_linear(plant, size.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; }));
}

/// Returns the states of all runs, one in each column.
MatrixXd states_of(const Dataset& runs) {
  const Index samples = runs.trajectories.front().samples();
  MatrixXd x(runs.trajectories.front().states.rows(), samples * static_cast<Index>(runs.trajectories.size()));
  for (std::size_t i = 0; i < runs.trajectories.size(); ++i)
    x.middleCols(static_cast<Index>(i) * samples, samples) = runs.trajectories[i].states;
  return x;
}

/// Returns, for each output, the largest difference between the held reading and h(x) between the samples.
VectorXd hold_error(const codegen::Model& model, const LinearPlant* linear, const DisturbedRuns& runs, double w_bar) {
  const bool steps = model.hold == Hold::kZeroOrder;
  if (linear == nullptr) return steps ? runs.step_error : runs.ramp_error;
  // y' = C (A x + w). Since w is held, y'' = C A (A x + w). A first-order hold has an error of at most h^2/8 |y''|, a
  // zero-order hold of at most h |y'|.
  const double h = model.sample_period_s;
  const MatrixXd &a = linear->a(), &c = linear->c();
  const double norm_a = spectral_norm(a);
  double x_max = 0.0;
  for (const Trajectory& run : runs.set.trajectories) x_max = std::max(x_max, run.states.colwise().norm().maxCoeff());
  x_max = (x_max + 0.5 * h * w_bar) * std::exp(0.5 * h * norm_a);  // covers the time between two samples
  const MatrixXd rows = steps ? c : MatrixXd(c * a);
  return (steps ? h : h * h / 8.0) * (norm_a * x_max + w_bar) * rows.rowwise().norm();
}

/// Returns sup |z(0) - T(x(0))| over the initial box of a linear plant, else the largest value over the runs.
double start_error(const codegen::Model& model, const Plant& plant, const SimulationConfig& simulation,
                   const MapConstants& map, const MatrixXd& initial, double noise) {
  const MatrixXd gain = codegen::linear_latent(model)->starts_steady ? codegen::steady_gain(model)
                                                                     : MatrixXd::Zero(model.nz(), model.ny());
  MatrixXd x = initial, t = map.start;
  // On a linear plant, the largest value is at a corner.
  if (map.exact && simulation.initial_distribution == InitialDistribution::kUniform && plant.nx() <= kMostCorners) {
    x = corners(VectorXd::Map(simulation.initial_low.data(), plant.nx()),
                VectorXd::Map(simulation.initial_high.data(), plant.nx()));
    t = map.matrix * x;
  }
  return ((gain * plant.output(x) - t).colwise() + model.initial_latent).colwise().norm().maxCoeff() +
         injected_bound(gain, VectorXd::Constant(plant.ny(), noise));
}

/// Runs the observer over both sets of runs and stores the largest errors in the result.
void measure(const codegen::Model& model, const DisturbedRuns& quiet, const DisturbedRuns& disturbed,
             const RobustnessQuestion& question, Robustness& result) {
  enum Kind { kQuiet, kUniform, kAbove, kBelow, kKinds };
  struct Found {
    double steady = 0.0, ratio = 0.0;
    VectorXd quiet_squares;
  };
  const auto runs = quiet.set.trajectories.size();
  const Index samples = quiet.set.trajectories.front().samples(), half = samples / 2;
  std::vector<Found> found(runs);
  ThreadPool pool(question.threads);
  std::vector<std::unique_ptr<codegen::ReferenceObserver<double>>> observers(static_cast<std::size_t>(pool.threads()));
  pool.run(static_cast<int>(runs), [&](int task, int thread) {
    auto& own = observers[static_cast<std::size_t>(thread)];
    if (!own) own = std::make_unique<codegen::ReferenceObserver<double>>(model);
    const auto i = static_cast<std::size_t>(task);
    for (int kind = 0; kind < kKinds; ++kind) {
      const Trajectory& truth = (kind == kQuiet ? quiet : disturbed).set.trajectories[i];
      MatrixXd y = truth.outputs;
      if (kind == kUniform) y = MeasurementNoise({NoiseKind::kUniform, question.noise}, question.seed, i).on(y);
      if (kind == kAbove) y.array() += question.noise;
      if (kind == kBelow) y.array() -= question.noise;
      const codegen::Run run = own->run(y, {}, truth.time_s, true);
      const VectorXd error = (run.x_hat - truth.states).colwise().norm();
      if (kind == kQuiet) {
        found[i].quiet_squares = error.cwiseAbs2();
        continue;
      }
      const double start = (run.z.col(0) - result.map.start.col(task)).norm();
      found[i].steady = std::max(found[i].steady, error.tail(samples - half).maxCoeff());
      for (Index n = 0; n < samples; ++n) {
        if (error(n) == 0.0) continue;
        const double ratio = error(n) / result.bound.at(truth.time_s(n), start);
        found[i].ratio = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : std::max(found[i].ratio, ratio);
      }
    }
  });
  VectorXd squares = VectorXd::Zero(samples);
  // In the order of the runs, so that the result has the same bytes for any number of threads.
  for (const Found& own : found) {
    squares += own.quiet_squares;
    result.steady_found = std::max(result.steady_found, own.steady);
    result.ratio_found = std::max(result.ratio_found, own.ratio);
  }
  const VectorXd rms = (squares / static_cast<double>(runs)).cwiseSqrt();
  result.transient_level = kTransientShare * rms(0) + result.approximation;
  Index last = samples - 1;
  while (last > 0 && rms(last) <= result.transient_level) --last;
  if (last + 1 < samples) result.transient_s = quiet.set.trajectories.front().time_s(last);
}

}  // namespace

Robustness robustness(const Plant& plant, const codegen::Model& model, const SimulationConfig& simulation,
                      const RobustnessQuestion& question) {
  const MatrixXd initial =
      draw_initial_states(simulation, initial_state_seed(question.seed, SeedStream::kTest), question.trajectories);
  const Linearity recognised = linearity_of(plant, initial);
  const auto* linear = recognised.plant ? recognised.plant.get() : dynamic_cast<const LinearPlant*>(&plant);
  const DisturbedRuns quiet = simulate_disturbed(plant, simulation, initial, 0.0, question.seed);
  const DisturbedRuns disturbed =
      question.disturbance > 0.0 ? simulate_disturbed(plant, simulation, initial, question.disturbance, question.seed)
                                 : quiet;
  const LatentSystem system = latent_system(model);

  Robustness result;
  MapConstants& map = result.map;
  map = linear != nullptr ? exact_map_constants(*linear, system, initial)
                          : sampled_map_constants(plant, system, quiet.set, initial);
  const MatrixXd x = map.exact ? states_of(quiet.set) : map.x, z = map.exact ? MatrixXd(map.matrix * x) : map.z;
  const MatrixXd y = plant.output(x);
  MatrixXd input(z.rows() + y.rows(), z.cols());
  input << z, y;
  const MatrixXd estimates = codegen::ReferenceNetwork<double>(*codegen::inverse_map(model))(input);
  result.approximation = (estimates - x).colwise().norm().maxCoeff();
  result.start = start_error(model, plant, simulation, map, initial, question.noise);

  LocalLipschitzOptions options;
  options.boxes = question.boxes;
  options.points =
      input(Eigen::all, Eigen::seqN(0, std::min(kSlopePoints, x.cols()), std::max<Index>(1, x.cols() / kSlopePoints)));
  const double slope = local_lipschitz(model, false, options).bound,
               of_output = local_lipschitz(model, true, options).bound;
  const double rate = slowest(system);
  const VectorXd noise = VectorXd::Constant(plant.ny(), question.noise);
  const auto bound = [&](const VectorXd& v, const VectorXd& held, double w_bar) -> ErrorBound {
    const double of_latent = steady_latent_error(system, v + held, w_bar, map.row_slopes);
    return {slope, rate, slope * of_latent + of_output * v.norm() + result.approximation};
  };
  const VectorXd held = hold_error(model, linear, disturbed, question.disturbance);
  result.bound = bound(noise, held, question.disturbance);
  result.quiet = bound(VectorXd::Zero(plant.ny()), hold_error(model, linear, quiet, 0.0), 0.0);
  result.paper = bound_19({plant.nx(), system.nz(), rate, map.l_t, map.l_tx}, 1.0, question.disturbance,
                          injected_bound(system.injection, noise + held));
  result.paper.steady += result.approximation;
  measure(model, quiet, disturbed, question, result);
  return result;
}

}  // namespace nlo::trainer
