// SPDX-License-Identifier: MIT
// Measurement noise as the paper probably applies it: plant and latent system are one ODE, integrated together by RK4,
// and each of its four stages draws its noise anew,
//   dx/dt = f(x),   dz/dt = D z + F (h(x) + v),   v fresh at every stage   (and likewise for (11) and (15)).
// To first order in the step, z therefore receives (v1 + 2 v2 + 2 v3 + v4) / 6. Its variance is 10/36 of the variance
// of a sensor that is read once per step and held. No sensor behaves like this, but code that calls an ODE solver on
// `D z + F (h(x) + noise())` does. Strict noise is in measurement_noise.h.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// A run of plant and latent system together, sample by sample.
struct JointRun {
  Dataset truth;                         ///< clean outputs and states
  std::vector<Eigen::MatrixXd> latent;   ///< n_z x N per trajectory
  std::vector<Eigen::MatrixXd> outputs;  ///< n_y x N per trajectory, with the noise of the step's first stage
};

/// Integrates from the columns of `initial` (n_x x B) at the sample period of `simulation`, with the excitation u(t) in
/// the plant and in phi(z) u (25) of a driven model. Trajectory i uses the noise of run `first_run + i` of `seed` (see
/// MeasurementNoise): stage after stage, and channel by channel in each stage.
JointRun integrate_with_stage_noise(const codegen::Model& model, const Plant& plant, const SimulationConfig& simulation,
                                    const Eigen::MatrixXd& initial, const NoiseConfig& noise, std::uint64_t seed,
                                    std::uint64_t first_run = 0, const Excitation& excitation = {});

/// Returns the errors of the model's estimates over such runs, with T* in float. `inputs` are expressions over t
/// (excitation.h). The result has the same bytes for any number of threads; 0: all cores. Throws codegen::Error if a
/// trajectory is no longer finite.
ErrorMetrics evaluate_with_stage_noise(const codegen::Model& model, const PlantConfig& plant,
                                       const SimulationConfig& simulation, const Eigen::MatrixXd& initial,
                                       const NoiseConfig& noise, std::uint64_t seed, int threads,
                                       const std::vector<std::string>& inputs = {});

}  // namespace nlo::trainer
