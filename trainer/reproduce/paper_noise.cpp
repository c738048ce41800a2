// SPDX-License-Identifier: MIT
#include "trainer/reproduce/paper_noise.h"

#include <algorithm>
#include <cstddef>

#include "codegen/reference/integrate.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/structures/structure_module.h"
#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

// Number of trajectories that are integrated and summed together. It is constant, so that neither the random numbers
// nor the order of the additions depends on the number of threads.
constexpr Eigen::Index kChunk = 20;

}  // namespace

JointRun integrate_with_stage_noise(const codegen::Model& model, const Plant& plant, const SimulationConfig& simulation,
                                    const Eigen::MatrixXd& initial, const NoiseConfig& noise, std::uint64_t seed,
                                    std::uint64_t first_run, const Excitation& excitation) {
  JointRun run;
  run.truth = simulate_from(plant, simulation, initial, excitation);
  const Eigen::Index batch = initial.cols(), samples = sample_count(simulation);
  const double h = simulation.sample_period_s;
  const auto latent = codegen::module_of(model).dynamics_in_double(model, codegen::Activations::kExact);
  std::vector<MeasurementNoise> sensors;
  for (Eigen::Index i = 0; i < batch; ++i) sensors.emplace_back(noise, seed, first_run + static_cast<std::uint64_t>(i));
  const auto measured = [&](const Eigen::MatrixXd& x) {
    Eigen::MatrixXd y = plant.output(x);
    for (Eigen::Index i = 0; i < batch; ++i)
      for (Eigen::Index j = 0; j < y.rows(); ++j)
        y(j, i) += sensors[static_cast<std::size_t>(i)].draw(static_cast<std::size_t>(j));
    return y;
  };

  const auto input = [&](double time_s) { return excitation ? excitation(time_s) : Eigen::VectorXd(); };

  run.latent.assign(static_cast<std::size_t>(batch), Eigen::MatrixXd(model.nz(), samples));
  run.outputs.assign(static_cast<std::size_t>(batch), Eigen::MatrixXd(model.ny(), samples));
  Eigen::MatrixXd x = initial, z = model.initial_latent.replicate(1, batch);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Eigen::MatrixXd y1 = measured(x);
    if (k == 0) latent->start(z, y1, nullptr);
    for (Eigen::Index i = 0; i < batch; ++i) {
      run.latent[static_cast<std::size_t>(i)].col(k) = z.col(i);
      run.outputs[static_cast<std::size_t>(i)].col(k) = y1.col(i);
    }
    if (k + 1 == samples) break;
    const double t = static_cast<double>(k) * h;
    const Eigen::VectorXd u1 = input(t), u2 = input(t + 0.5 * h), u4 = input(t + h);
    // One Runge-Kutta step of plant and observer together: each stage draws a new measurement.
    Eigen::MatrixXd joint(x.rows() + z.rows(), batch);
    joint << x, z;
    joint = codegen::rk4_step(joint, h, [&](double c, const Eigen::MatrixXd& at) {
      const Eigen::VectorXd& u = c == 0.0 ? u1 : c == 1.0 ? u4 : u2;
      const Eigen::MatrixXd state = at.topRows(x.rows());
      Eigen::MatrixXd slope(at.rows(), batch);
      slope << driven_derivative(plant, state, u),
          latent->slope(at.bottomRows(z.rows()), c == 0.0 ? y1 : measured(state), u);
      return slope;
    });
    x = joint.topRows(x.rows());
    z = joint.bottomRows(z.rows());
  }
  return run;
}

ErrorMetrics evaluate_with_stage_noise(const codegen::Model& model, const PlantConfig& plant,
                                       const SimulationConfig& simulation, const Eigen::MatrixXd& initial,
                                       const NoiseConfig& noise, std::uint64_t seed, int threads,
                                       const std::vector<std::string>& inputs) {
  const Eigen::Index chunks = (initial.cols() + kChunk - 1) / kChunk;
  const std::vector<codegen::Channel> states = make_plant(plant)->states();
  std::vector<ErrorAccumulator> sums(static_cast<std::size_t>(chunks),
                                     ErrorAccumulator(states, simulation.sample_period_s));
  ThreadPool(threads).run(static_cast<int>(chunks), [&](int task, int) {
    const Eigen::Index first = task * kChunk, count = std::min(kChunk, initial.cols() - first);
    const auto own_plant = make_plant(plant);  // two threads must not share a plant
    const JointRun run =
        integrate_with_stage_noise(model, *own_plant, simulation, initial.middleCols(first, count), noise, seed,
                                   static_cast<std::uint64_t>(first), parse_excitation(*own_plant, inputs));
    const codegen::ReferenceObserver<float> observer(model);
    for (std::size_t i = 0; i < run.latent.size(); ++i)
      sums[static_cast<std::size_t>(task)].add(run.truth.trajectories[i],
                                               observer.estimates(run.latent[i], run.outputs[i]));
  });
  ErrorAccumulator total(states, simulation.sample_period_s);
  for (const ErrorAccumulator& sum : sums) total.merge(sum);
  return total.metrics();
}

}  // namespace nlo::trainer
