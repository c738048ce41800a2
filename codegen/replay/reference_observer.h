// SPDX-License-Identifier: MIT
// The equations of structures/ with dynamic sizes and without folding. Exports are compared with it (in double), and
// `nlo evaluate` runs it over whole trajectories (in float).
#pragma once

#include <nlo/vector.h>
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "codegen/model/domain.h"
#include "codegen/model/model.h"
#include "codegen/reference/dynamics.h"
#include "codegen/reference/quantised_network.h"
#include "codegen/reference/reference_network.h"
#include "codegen/replay/sample_validation.h"

namespace nlo::codegen {

/// The results of the observer over a trajectory of N samples.
struct Run {
  Eigen::MatrixXd x_hat;       ///< n_x x N
  Eigen::MatrixXd z;           ///< n_z x N
  Eigen::MatrixXd y;           ///< n_r x N, the outputs (then the inputs that it reads) that were used: held, clamped
  Eigen::MatrixXd sigma = {};  ///< n_x x N, half widths of the 68 % intervals; 0 x 0 for a model without an error head
  Eigen::MatrixXd widened_sigma = {};   ///< n_x x N, widened by the monitor; 0 x 0 without error head or monitor
  std::vector<StepStatus> status = {};  ///< N, status of each step
  std::vector<bool> in_domain = {};     ///< N, as in_domain() of the observer
};

/// How angles are given: wrapped within one turn, as a sensor measures them, or continued beyond it.
enum class Angles { kWrapped, kUnwrapped };

template <class Scalar>
class ReferenceObserver {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the model. Throws Error if it is not valid (see validate.h).
  explicit ReferenceObserver(const Model& model);

  /// Makes an observer without validation, with the activations of the runtime, for a model that export has rewritten.
  /// With `integers`, which must outlive the observer, z moves as they do (float only). `ranges` come from the model
  /// before it was rewritten, because the rewritten T* may not show which outputs it reads relatively.
  ReferenceObserver(const Model& model, Activations activations, FlownRanges ranges,
                    const QuantisedModel* integers = nullptr);

  /// Sets z to its initial value. The next sample is the first one.
  void reset();

  /// Steps over one sample period with the outputs `y` (n_y) and the inputs `u` (n_u), which are validated as by
  /// SampleValidation. Does nothing before the first good sample.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u = {});

  /// Steps over `dt_s` since the last sample. Does nothing if `dt_s` is not positive or longer than the structure
  /// allows.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s);

  /// Returns x_hat, n_x.
  Vector estimate() const;

  /// Returns z, n_z. Angles and z are unwrapped from the first sample on. To compare z with an observer that turns z
  /// back, subtract steady_gain() times the turns. Outputs that T* reads only relatively are reduced by whole turns as
  /// in flight.
  const Vector& latent() const { return z_; }

  /// Returns the readings that the last step used, n_r: held, clamped, angles unwrapped.
  const Eigen::VectorXd& output() const { return validation_->y(); }

  /// Returns true if z is in the domain and no reading of the last step is clamped, as in the runtime.
  bool in_domain() const;

  /// Returns true if in_domain() and no reading is stale or out of range, as in the runtime.
  bool error_is_known() const { return in_domain() && status_ < StepStatus::kStale; }

  /// Returns the status that the observer of the runtime returns for the last step.
  StepStatus status() const { return status_; }

  /// Returns the status of one output in the last step.
  StepStatus status(Eigen::Index output) const { return validation_->status(output); }
  /// Returns true if an output arrived in the last step, or if it has no period of its own.
  bool has_arrived(Eigen::Index output) const { return validation_->has_arrived(output); }

  /// Returns true if the last step was left out because its result was not finite.
  bool diverged() const { return status_ == StepStatus::kDiverged; }

  /// snapshot() returns everything that a step changes, as snapshot_size() numbers. If another observer of the same
  /// model restores them with restore(), its next steps give the same bits.
  Eigen::Index snapshot_size() const;
  Eigen::VectorXd snapshot() const;
  /// Throws Error and changes nothing if the snapshot is not one of this model.
  void restore(const Eigen::VectorXd& snapshot);

  /// Runs a whole trajectory from reset: `outputs` n_y x N, `inputs` n_u x N (0 x 0 if there are none), `time_s` N.
  /// With `uniform` each step is the sample period. Otherwise it is the difference of the time stamps; a difference
  /// that is the sample period except for rounding counts as the period. Estimates are computed by matrix products for
  /// many samples at once. Throws Error if the inputs do not fit the model.
  Run run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s, bool uniform,
          Angles angles = Angles::kUnwrapped);

  /// Returns x_hat (n_x x N) for any columns of z (n_z x N) and readings y (n_r x N).
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

  /// Returns the standard deviations of the errors, n_x x N, as sigma of estimate_with_error(). 0 x 0 if the model has
  /// no error head. known, N: error_is_known() of the observer.
  Eigen::MatrixXd deviations(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const std::vector<bool>& known) const;

  /// Returns the last hidden layer of T*, n_h x N, which the error head reads. T* must have one.
  Eigen::MatrixXd last_hidden(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

 private:
  void take(const Eigen::VectorXd& y, const Eigen::VectorXd& u, bool wrapped, double dt_s);
  void advance(double dt_s);
  void turn_back();
  Eigen::MatrixXd estimates_in_blocks(const Matrix& z, const Matrix& y) const;
  Matrix estimate_of(const Matrix& z, const Matrix& y) const;
  Matrix saturated(const Matrix& z, const Matrix& y) const;
  Matrix read_by_map(const Matrix& z, const Matrix& y) const;

  std::unique_ptr<const Model> model_;  // all parts of the observer point to this copy
  LatentDomain domain_;
  Eigen::MatrixXd steady_gain_;  // S, n_z x n_r
  std::unique_ptr<SampleValidation> validation_;
  std::unique_ptr<ReferenceDynamics<Scalar>> dynamics_;
  std::optional<ReferenceNetwork<Scalar>> inverse_map_;  // empty: z is the estimate
  std::optional<LatentDomain> saturated_;                // empty: T* reads z without limits

  Vector z_;
  Vector candidate_, last_y_, next_y_, last_u_, next_u_;  // members, so that a step allocates little
  StepStatus status_ = StepStatus::kOk;
  bool started_ = false;
};

// Compiled once, in reference_observer.cpp, which is optimised for speed.
extern template class ReferenceObserver<float>;
extern template class ReferenceObserver<double>;

}  // namespace nlo::codegen
