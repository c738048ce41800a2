// SPDX-License-Identifier: MIT
// Proposition 2 for a KKL observer and its plant: the constants of the bound (19), the bounds that follow from them,
// and the largest errors of simulated runs.
//
// On a linear plant T and its constants are known exactly (Sylvester). On other plants they are the largest values at
// samples, and so is the approximation error of T* on every plant. A bound made from such values is an estimate.
#pragma once

#include <cstdint>
#include <optional>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"
#include "trainer/prove/map_constants.h"
#include "trainer/prove/robustness_bound.h"

namespace nlo::trainer {

struct RobustnessQuestion {
  double noise = 0.0;        ///< V: largest deviation of a sample of an output
  double disturbance = 0.0;  ///< w_bar: largest |w| on the state's derivative
  int trajectories = 100;    ///< simulated runs
  std::uint64_t seed = 1;    ///< seed of the initial states, the noise and the disturbance
  std::int64_t boxes = 0;    ///< see LocalLipschitzOptions::boxes
  int threads = 1;           ///< does not affect the result
};

struct Robustness {
  MapConstants map;            ///< L_T, L_Tx; exact on a linear plant
  double approximation = 0.0;  ///< eps: largest |T*(T(x)) - x| at samples [state]
  double start = 0.0;          ///< e0: largest |z(0) - T(x(0))|

  // Bounds of |x_hat - x| after an initial error of e0. Lipschitz constants of T* are those over the box of the domain.
  ErrorBound bound;  ///< each mode at its own rate, with noise and disturbance
  ErrorBound quiet;  ///< `bound` without noise and disturbance
  ErrorBound paper;  ///< (19) as printed, plus eps

  // Largest errors of the runs. Noise is drawn uniformly for each sample, or is +V or -V at all samples.
  double steady_found = 0.0;     ///< |x_hat - x| in the second half of the horizon
  double ratio_found = 0.0;      ///< error / bound at any time, with noise and disturbance
  double transient_level = 0.0;  ///< a tenth of the initial error, rms over the runs without noise, plus eps
  /// Last time at which this rms is above the level. Empty if it still is at the end of the horizon.
  std::optional<double> transient_s;
};

/// `model`: a KKL observer without inputs that estimates the states of `plant`. `simulation` has its initial states,
/// sample period and horizon. Throws codegen::Error if the plant cannot be simulated, or if T of a linear plant is not
/// injective.
Robustness robustness(const Plant& plant, const codegen::Model& model, const SimulationConfig& simulation,
                      const RobustnessQuestion& question);

}  // namespace nlo::trainer
