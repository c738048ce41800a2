// SPDX-License-Identifier: MIT
#include "trainer/evaluation/paper_noise.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "codegen/latent_step.h"
#include "codegen/reference_network.h"
#include "trainer/base/parallel.h"
#include "trainer/evaluation/measurement_noise.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

// Trajectories that are integrated together, and whose errors are summed together: fixed, so that neither the draws nor
// the order of the additions depends on the number of threads.
constexpr Eigen::Index kChunk = 20;

/// D, n_z x n_z: the 2x2 blocks of the pairs, then the real eigenvalues.
Eigen::MatrixXd latent_matrix(const codegen::Model& model) {
  Eigen::MatrixXd d = model.eigenvalues.asDiagonal();
  for (Eigen::Index row = 0; row < 2 * model.pairs; row += 2) {
    const double re = model.eigenvalues[row], im = model.eigenvalues[row + 1];
    d.block<2, 2>(row, row) << re, -im, im, re;
  }
  return d;
}

/// dz/dt of a model's structure, one column per trajectory.
class LatentSlope {
 public:
  explicit LatentSlope(const codegen::Model& model) : model_(model) {
    if (model.luenberger) network_.emplace(model.luenberger->nonlinearity);
    if (model.dynamics) network_.emplace(*model.dynamics);
    if (codegen::has_linear_latent(model)) d_ = latent_matrix(model);
    if (model.drive) {
      network_.emplace(model.inverse_map);
      forward_map_.emplace(model.drive->forward_map);
    }
  }

  /// z n_z x B, y n_y x B, one u (n_u) for all; empty: none.
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const Eigen::VectorXd& u) const {
    if (model_.luenberger) {
      const codegen::LuenbergerDynamics& known = *model_.luenberger;
      return known.state_matrix * z + (*network_)(z) + known.gain * (y - known.output_matrix * z);
    }
    if (model_.dynamics) return (*network_)(stacked(z, y));
    Eigen::MatrixXd slope = d_ * z + model_.output_injection * y;
    if (model_.drive && u.size() != 0) slope += drive(z, y, u);
    return slope;
  }

  static Eigen::MatrixXd stacked(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) {
    Eigen::MatrixXd both(z.rows() + y.rows(), z.cols());
    both << z, y;
    return both;
  }

 private:
  /// phi(z) u = dT/dx(x_hat) g(x_hat) u, x_hat = T*(z).
  Eigen::MatrixXd drive(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const Eigen::VectorXd& u) const {
    const Eigen::MatrixXd x_hat = (*network_)(stacked(z, y));
    const codegen::DenseLayer& field = model_.drive->input_field;
    Eigen::MatrixXd phi_u(z.rows(), z.cols());
    for (Eigen::Index i = 0; i < z.cols(); ++i) {
      const Eigen::VectorXd g = field.weights * x_hat.col(i) + field.bias;  // one column of g after the other
      const Eigen::VectorXd direction = g.reshaped(model_.nx(), model_.nu()) * u;
      phi_u.col(i) = forward_map_->jvp(x_hat.col(i), direction);
    }
    return phi_u;
  }

  const codegen::Model& model_;
  std::optional<codegen::ReferenceNetwork<double>> network_, forward_map_;
  Eigen::MatrixXd d_;
};

/// T* over [z; y], in blocks that stay in cache; the latent state of a Luenberger-like observer is its estimate.
Eigen::MatrixXd estimates(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) {
  if (model.luenberger) return z;
  constexpr Eigen::Index kBlock = 512;  // 50 neurons x 512 floats: a layer's input and output stay in the L2 cache
  const codegen::ReferenceNetwork<float> inverse_map(model.inverse_map);
  const Eigen::MatrixXf inputs = LatentSlope::stacked(z, y).cast<float>();
  Eigen::MatrixXd x_hat(model.nx(), z.cols());
  for (Eigen::Index k = 0; k < z.cols(); k += kBlock) {
    const Eigen::Index n = std::min(kBlock, z.cols() - k);
    x_hat.middleCols(k, n) = inverse_map(inputs.middleCols(k, n)).cast<double>();
  }
  return x_hat;
}

}  // namespace

JointRun integrate_with_stage_noise(const codegen::Model& model, const Plant& plant, const SimulationConfig& simulation,
                                    const Eigen::MatrixXd& initial, const NoiseConfig& noise, std::uint64_t seed,
                                    std::uint64_t first_run, const Excitation& excitation) {
  JointRun run;
  run.truth = simulate_from(plant, simulation, initial, excitation);
  const Eigen::Index batch = initial.cols(), samples = sample_count(simulation);
  const double h = simulation.sample_period_s;
  const LatentSlope slope(model);
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
    if (k == 0 && model.starts_steady) z += codegen::steady_gain(model) * y1;
    for (Eigen::Index i = 0; i < batch; ++i) {
      run.latent[static_cast<std::size_t>(i)].col(k) = z.col(i);
      run.outputs[static_cast<std::size_t>(i)].col(k) = y1.col(i);
    }
    if (k + 1 == samples) break;
    const double t = static_cast<double>(k) * h;
    const Eigen::VectorXd u1 = input(t), u2 = input(t + 0.5 * h), u4 = input(t + h);
    const Eigen::MatrixXd f1 = driven_derivative(plant, x, u1), g1 = slope(z, y1, u1);
    const Eigen::MatrixXd x2 = x + 0.5 * h * f1, f2 = driven_derivative(plant, x2, u2);
    const Eigen::MatrixXd g2 = slope(z + 0.5 * h * g1, measured(x2), u2);
    const Eigen::MatrixXd x3 = x + 0.5 * h * f2, f3 = driven_derivative(plant, x3, u2);
    const Eigen::MatrixXd g3 = slope(z + 0.5 * h * g2, measured(x3), u2);
    const Eigen::MatrixXd x4 = x + h * f3, f4 = driven_derivative(plant, x4, u4);
    const Eigen::MatrixXd g4 = slope(z + h * g3, measured(x4), u4);
    x += h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4);
    z += h / 6.0 * (g1 + 2.0 * g2 + 2.0 * g3 + g4);
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
    const auto own_plant = make_plant(plant);  // plants are not for two threads at once
    const JointRun run =
        integrate_with_stage_noise(model, *own_plant, simulation, initial.middleCols(first, count), noise, seed,
                                   static_cast<std::uint64_t>(first), parse_excitation(*own_plant, inputs));
    for (std::size_t i = 0; i < run.latent.size(); ++i)
      sums[static_cast<std::size_t>(task)].add(run.truth.trajectories[i],
                                               estimates(model, run.latent[i], run.outputs[i]));
  });
  ErrorAccumulator total(states, simulation.sample_period_s);
  for (const ErrorAccumulator& sum : sums) total.merge(sum);
  return total.metrics();
}

}  // namespace nlo::trainer
