// SPDX-License-Identifier: MIT
// The equations of structures/ with dynamic sizes and nothing folded. It is the oracle for exports (double), and
// `nlo evaluate` runs it over whole trajectories (float).
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

/// The observer's answers over one trajectory of N samples.
struct Run {
  Eigen::MatrixXd x_hat;       ///< n_x x N
  Eigen::MatrixXd z;           ///< n_z x N
  Eigen::MatrixXd y;           ///< n_r x N, the outputs (then the inputs it reads) as they were taken: held, clamped
  Eigen::MatrixXd sigma = {};  ///< n_x x N, half widths of the 68 % intervals; 0 x 0 for a model without an error head
  Eigen::MatrixXd widened_sigma = {};   ///< n_x x N, as the monitor widens them; 0 x 0 without error head or monitor
  std::vector<StepStatus> status = {};  ///< N, status of each step
  std::vector<bool> in_domain = {};     ///< N, as in_domain() of the observer
};

/// How angles are given: as a sensor has them, within one turn, or continued beyond it.
enum class Angles { kWrapped, kUnwrapped };

template <class Scalar>
class ReferenceObserver {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the model. Throws Error unless it is valid (see validate.h).
  explicit ReferenceObserver(const Model& model);

  /// Makes an observer without validation, with the runtime's activations, for a model that is rewritten as it is
  /// exported. With `integers`, which must outlive the observer, z moves as they do (float only).
  /// `ranges`: from the model before it was rewritten, because the rewritten T* may not show which outputs it reads
  /// relatively.
  ReferenceObserver(const Model& model, Activations activations, FlownRanges ranges,
                    const QuantisedModel* integers = nullptr);

  /// z = initial latent; the next sample is the first.
  void reset();

  /// One sample period with the outputs `y` (n_y) and the inputs `u` (n_u), validated as SampleValidation does. Before
  /// the first good sample, nothing happens.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u = {});

  /// Steps over `dt_s` since the last sample. Does nothing if `dt_s` is not positive or longer than the structure can
  /// span.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s);

  /// x_hat, n_x.
  Vector estimate() const;

  /// z, n_z. Angles are unwrapped from the first sample on, and z with them: subtract steady_gain() times the turns to
  /// compare with an observer that turns z back. Outputs that T* knows only relatively are turned back as in flight.
  const Vector& latent() const { return z_; }

  /// The readings as the last step took them, n_r: held, clamped, angles unwrapped.
  const Eigen::VectorXd& output() const { return validation_->y(); }

  /// As the runtime's: z is in the domain, and no reading of the last step is clamped.
  bool in_domain() const;

  /// As the runtime's: in_domain(), and no reading is stale or out of range.
  bool error_is_known() const { return in_domain() && status_ < StepStatus::kStale; }

  /// The status that the runtime's observer returns for the last step.
  StepStatus status() const { return status_; }

  /// Status of one output in the last step.
  StepStatus status(Eigen::Index output) const { return validation_->status(output); }
  /// Returns true if an output arrived in the last step, and for one without a period of its own.
  bool has_arrived(Eigen::Index output) const { return validation_->has_arrived(output); }

  /// The last step would have left the finite numbers: z was kept.
  bool diverged() const { return status_ == StepStatus::kDiverged; }

  /// All that a step changes, as numbers that restore() takes: snapshot_size() of them. An observer of the same model
  /// goes on from there with the same bits.
  Eigen::Index snapshot_size() const;
  Eigen::VectorXd snapshot() const;
  /// Throws Error, and changes nothing, unless it is one of this model.
  void restore(const Eigen::VectorXd& snapshot);

  /// A whole trajectory from reset: `outputs` n_y x N, `inputs` n_u x N (0 x 0 where there are none), `time_s` N. With
  /// `uniform` each step is the sample period, else it is the difference of the time stamps, where a difference that
  /// is the sample period but for the stamps' rounding counts as the period. Estimates are products of matrices, for
  /// many samples at once. Throws Error when the inputs are not those of the model.
  Run run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s, bool uniform,
          Angles angles = Angles::kUnwrapped);

  /// x_hat (n_x x N) for the columns of z (n_z x N) and readings y (n_r x N), wherever they come from.
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

  /// The standard deviations of their errors, n_x x N: sigma of estimate_with_error().
  /// 0 x 0 of a model that knows none. known, N: error_is_known() of the observer.
  Eigen::MatrixXd deviations(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const std::vector<bool>& known) const;

  /// The last hidden layer of T* there, n_h x N, for a model whose T* has one. The error head reads it.
  Eigen::MatrixXd last_hidden(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

 private:
  void take(const Eigen::VectorXd& y, const Eigen::VectorXd& u, bool wrapped, double dt_s);
  void advance(double dt_s);
  void turn_back();
  Eigen::MatrixXd estimates_in_blocks(const Matrix& z, const Matrix& y) const;
  Matrix estimate_of(const Matrix& z, const Matrix& y) const;
  Matrix saturated(const Matrix& z, const Matrix& y) const;
  Matrix read_by_map(const Matrix& z, const Matrix& y) const;

  std::unique_ptr<const Model> model_;  // one place for all holders of the observer
  LatentDomain domain_;
  Eigen::MatrixXd steady_gain_;  // S, n_z x n_r
  std::unique_ptr<SampleValidation> validation_;
  std::unique_ptr<ReferenceDynamics<Scalar>> dynamics_;
  std::optional<ReferenceNetwork<Scalar>> inverse_map_;  // none: z is the estimate
  std::optional<LatentDomain> saturated_;                // none: T* reads z wherever it goes

  Vector z_;
  Vector candidate_, last_y_, next_y_, last_u_, next_u_;  // members, so that a step allocates little
  StepStatus status_ = StepStatus::kOk;
  bool started_ = false;
};

// Compiled once, for speed, in reference_observer.cpp.
extern template class ReferenceObserver<float>;
extern template class ReferenceObserver<double>;

}  // namespace nlo::codegen
