// SPDX-License-Identifier: MIT
// Compares an export with its model: runs replay inputs through the model's equations in double and through the
// exported arithmetic, emulated on this machine. Golden outputs come from here; the stated error of an export comes
// from export_error.h.
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/replay/replay_inputs.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// Emulates an exported observer: `folded` comes from in_formats() of number_formats.h, rounded to the scalar of the
/// target, with the activations of the runtime. In int16, the inverse map has the bits of the runtime. To add a number
/// format, add a case here.
class ExportedObserver {
 public:
  /// `quantised`: the integer parts, which must outlive this object; null for other scalars.
  ExportedObserver(const Model& model, const FoldedModel& folded, const QuantisedModel* quantised, ScalarType scalar);

  void reset();
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s);

  /// Returns z, n_z, with unwrapped angles as in ReferenceObserver::latent().
  Eigen::VectorXd latent() const;

  /// Returns x_hat from z and y.
  Eigen::VectorXd estimate(const Eigen::VectorXd& z, const Eigen::VectorXd& y) const;

  /// Returns the standard deviations of the errors, n_x; empty if the export has none. known: in_domain() is true
  /// there.
  Eigen::VectorXd deviation(const Eigen::VectorXd& z, const Eigen::VectorXd& y, bool known) const;

  /// Returns estimates for each column of z and y, n_x x N. Sums of floats may round differently.
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

 private:
  std::variant<ReferenceObserver<float>, ReferenceObserver<double>> observer_;
  const QuantisedModel* quantised_;
};

/// Returns the whole turns that the exported observer subtracts from the angles among the readings `y`, n_r.
Eigen::VectorXd turns_in(const Model& model, const Eigen::VectorXd& y);

/// N samples.
struct ReplayRun {
  ReplayInputs inputs;             ///< as the export reads them, rounded to its scalar
  std::vector<StepStatus> status;  ///< expected status of each sample
  std::vector<bool> in_domain;     ///< z is within the domain
  Eigen::MatrixXd z, x_hat;        ///< n_z x N, n_x x N: the model's equations in double, angles turned back. int16:
                                   ///< T* of the nearest point of its input box
  Eigen::MatrixXd sigma;           ///< n_x x N, of estimate_with_error(); 0 x 0 where the export has none
  Eigen::MatrixXd exported_z, exported_x_hat, exported_sigma;
};

/// Runs `options.samples` replay inputs, small enough that at least half of them stay in the domain if possible. The
/// outputs of a model with known equations follow the equations if that makes the difference between exported and exact
/// estimates ten times smaller.
/// `folded`: as `options` export it (number_formats.h). Throws Error if the number of samples is not valid.
ReplayRun run_replay(const Model& model, const FoldedModel& folded, const QuantisedModel* quantised,
                     const ExportOptions& options);

}  // namespace nlo::codegen
