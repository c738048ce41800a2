// SPDX-License-Identifier: MIT
// An export against its model: replay inputs through the model's equations in double and, beside them, through the
// exported arithmetic, emulated on this machine. Golden answers come from here; the stated error of an export comes
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

/// The observer as it is exported: `folded` as in_formats() of number_formats.h gives it, rounded to the scalar
/// of the target, the runtime's activations. int16: the inverse map with the very bits of the runtime. Another format
/// of numbers is one more case here.
class ExportedObserver {
 public:
  /// `quantised`: the parts in integers, which must outlive this; null in the other scalars.
  ExportedObserver(const Model& model, const FoldedModel& folded, const QuantisedModel* quantised, ScalarType scalar);

  void reset();
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s);

  /// z, n_z; angles unwrapped, as ReferenceObserver::latent().
  Eigen::VectorXd latent() const;

  /// x_hat from z and y.
  Eigen::VectorXd estimate(const Eigen::VectorXd& z, const Eigen::VectorXd& y) const;

  /// The standard deviations of the errors, n_x; size 0 where the export has none. known: in_domain() is true there.
  Eigen::VectorXd deviation(const Eigen::VectorXd& z, const Eigen::VectorXd& y, bool known) const;

  /// Estimates for each column of z and y, n_x x N. Sums of floats may round differently.
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

 private:
  std::variant<ReferenceObserver<float>, ReferenceObserver<double>> observer_;
  const QuantisedModel* quantised_;
};

/// Whole turns of the angles among the readings `y`, n_r, which the exported observer takes back.
Eigen::VectorXd turns_in(const Model& model, const Eigen::VectorXd& y);

/// N samples.
struct ReplayRun {
  ReplayInputs inputs;             ///< as the export reads them: rounded to its scalar
  std::vector<StepStatus> status;  ///< expected status of each sample
  std::vector<bool> in_domain;     ///< z lies where training has been
  Eigen::MatrixXd z, x_hat;        ///< n_z x N, n_x x N: the model's equations in double, angles turned back. int16:
                                   ///< T* of the nearest point of its input box
  Eigen::MatrixXd sigma;           ///< n_x x N, of estimate_with_error(); 0 x 0 where the export has none
  Eigen::MatrixXd exported_z, exported_x_hat, exported_sigma;
};

/// Runs `options.samples` replay inputs, small enough that at least half of them stay in the domain where that can be.
/// `folded`: as `options` export it (number_formats.h). Throws Error when that many samples make no sense.
ReplayRun run_replay(const Model& model, const FoldedModel& folded, const QuantisedModel* quantised,
                     const ExportOptions& options);

}  // namespace nlo::codegen
