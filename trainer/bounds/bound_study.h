// SPDX-License-Identifier: MIT
// Proposition 2 on a plant: every constant of the bound (19) for D_k = k D, the bounds that follow, and the errors that
// observers with these D_k make under bounded noise and disturbance.
//
// On a linear plant T_k and its pseudo-inverse are known exactly (Sylvester), so is every constant, and a measurement
// above the bound is a defect. Elsewhere the constants of T_k are the largest found at samples, and a bound made from
// them is an estimate, which is how it is labelled: what bounds the error may be larger or smaller.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/bounds/evidence.h"
#include "trainer/bounds/map_constants.h"
#include "trainer/bounds/robustness_bound.h"
#include "trainer/config/experiment.h"
#include "trainer/evaluation/disturbed_runs.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant.h"
#include "trainer/plants/plant_form.h"

namespace nlo::trainer {

struct BoundTest {
  double noise = 0.0;        ///< V: each sample of each output is off by at most this
  double disturbance = 0.0;  ///< w_bar
  int trajectories = 100;
  std::uint64_t seed = 1;  ///< of the initial states, the noise and the disturbance
  int threads = 0;         ///< 0: all cores; does not change the result
  std::int64_t boxes = 0;  ///< LocalLipschitzOptions::boxes
};

/// A constant of the bound, for people.
struct BoundConstant {
  std::string symbol, meaning;
  Evidence evidence = Evidence::kSampled;
  double value = 0.0;  ///< infinite or NaN where it has none
};

/// The bounds of |x - x_hat|. On a linear plant all but the last are the same.
enum BoundKind {
  kSlopesBound,   ///< as kWeightsBound, with T*'s largest slope at samples instead
  kBoxBound,      ///< with T*'s Lipschitz constant over the domain's box instead: while z and T(x) are in it
  kWeightsBound,  ///< the remark with T*'s Lipschitz constant from its weights, each mode at its own rate
  kPaperBound,    ///< (19) as printed, plus the approximation error
  kBoundKinds
};
using BoundSet = std::array<ErrorBound, kBoundKinds>;

/// What the observer did. "Steady": the second half of the horizon.
struct BoundMeasurement {
  double steady_rms = 0.0, steady_max = 0.0;  ///< noise drawn uniformly, a fresh draw per sample
  double offset_max = 0.0;                    ///< all noise at +V or at -V: what a bound for all noises must cover
  double quiet_rms = 0.0;                     ///< no noise, no disturbance
  double transient_level = 0.0;               ///< see BoundResult
  std::optional<double> transient_s;          ///< see BoundResult; none: still above at the end of the horizon
  std::optional<double> settling_s;           ///< the same above a tenth plus quiet_rms, which no bound covers
  std::array<double, kBoundKinds> ratio{};    ///< largest error / bound over runs and time
};

struct BoundResult {
  double k = 1.0;
  std::string inverse_map;  ///< "pseudo-inverse", "the model's own", "retrained, 2000 steps"
  std::vector<BoundConstant> constants;
  BoundSet bounds;
  BoundMeasurement measured;

  /// Without noise and disturbance: when |x - x_hat| was last above transient_level = a tenth of its initial value plus
  /// eps, the approximation error, which stays whatever the time. Measured: root mean square over the runs, at its last
  /// sample above. Bounds: all of the bound, eps and the hold's error included; infinite where it settles above. [s]
  std::array<double, kBoundKinds> transient_s{};

  double l_tkx = 0.0;             ///< |dT_k/dx|; infinite: T_k is not differentiable
  bool power_claim_holds = true;  ///< L_Tk <= k^n_z L_T
  bool slope_claim_holds = true;  ///< L_Tkx <= L_Tx / k
  /// Largest |dT/dx f - D T - F h| / (|D T| + |F h|) at the initial states; 0 where T is exact.
  double pde_residual = 0.0;
};

/// Results for several k, and under what conditions.
struct BoundReport {
  std::string model, plant;
  bool exact = false;
  BoundTest test;
  double horizon_s = 0.0;
  std::vector<BoundResult> results;
  bool affine = false;  ///< see BoundStudy::affine()
};

class BoundStudy {
 public:
  /// `model` gives D, F and the hold; `experiment` the plant's initial states and sampling. Keeps a reference to
  /// `plant`. Throws codegen::Error when the plant cannot be simulated, or when T of a linear plant is not injective.
  BoundStudy(const Plant& plant, const codegen::Model& model, const SimulationConfig& simulation,
             const BoundTest& test);
  BoundStudy(const BoundStudy&) = delete;
  BoundStudy& operator=(const BoundStudy&) = delete;

  /// A linear plant, built in or recognised in its expressions: T_k and T*_k are exact.
  bool exact() const { return linear_ != nullptr; }

  /// Not exact, but for offsets of f and h alone.
  bool affine() const { return recognised_.affine; }

  /// With exact(): the observer of k D whose inverse map is the pseudo-inverse of T_k.
  codegen::Model exact_observer(double k) const;

  /// All constants, bounds and measurements of k. `observer` has eigenvalues k D.
  BoundResult at(double k, const codegen::Model& observer, const std::string& inverse_map) const;

 private:
  MapConstants map_of(const LatentSystem& system) const;
  Eigen::VectorXd hold_error(const DisturbedRuns& runs, double w_bar) const;
  bool starts_are_in_a_box() const;
  double initial_error(const codegen::Model& observer, const MapConstants& map) const;
  BoundMeasurement measure(const codegen::Model& observer, const MapConstants& map, const BoundSet& noisy,
                           const BoundSet& quiet, double approximation) const;

  const Plant& plant_;
  codegen::Model model_;
  SimulationConfig simulation_;
  BoundTest test_;
  Eigen::MatrixXd initial_;
  Linearity recognised_;
  const LinearPlant* linear_;
  DisturbedRuns quiet_, disturbed_;
  MapConstants base_;  ///< of k = 1
};

}  // namespace nlo::trainer
