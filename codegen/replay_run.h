// SPDX-License-Identifier: MIT
// An export against its model: replay inputs through the model's equations in double and, beside them, through the
// exported arithmetic, emulated on this machine. Golden answers come from here; what an export states of its error,
// from export_error.h.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "codegen/fold.h"
#include "codegen/quantise.h"
#include "codegen/reference_observer.h"
#include "codegen/targets/registry.h"
#include "codegen/targets/replay_inputs.h"

namespace nlo::codegen {

/// The observer as it is exported: `folded` as fold(model, options) of number_formats.h gives it, rounded to the scalar
/// of the target, the runtime's activations. int16: the inverse map with the very bits of the runtime. Another format
/// of numbers is one more case here.
class ExportedObserver {
 public:
  ExportedObserver(const Model& model, const FoldedModel& folded, ScalarType scalar);

  void reset();
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s);

  /// z, n_z; angles unwrapped, as ReferenceObserver::latent().
  Eigen::VectorXd latent() const;

  /// x_hat from z and y.
  Eigen::VectorXd estimate(const Eigen::VectorXd& z, const Eigen::VectorXd& y) const;

  /// The same of each column, n_x x N. The sums of floats may round otherwise.
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const;

 private:
  std::variant<ReferenceObserver<float>, ReferenceObserver<double>> observer_;
  std::optional<QuantisedNetwork> quantised_;
};

/// Whole turns of the angles among `y`, n_y, which the exported observer takes back.
Eigen::VectorXd turns_in(const Model& model, const Eigen::VectorXd& y);

/// N samples.
struct ReplayRun {
  ReplayInputs inputs;              ///< as the export reads them: rounded to its scalar
  std::vector<std::string> status;  ///< StepStatus that each must give
  std::vector<bool> in_domain;      ///< z lies where training has been
  Eigen::MatrixXd z, x_hat;         ///< n_z x N, n_x x N: the model's equations in double, angles turned back. int16:
                                    ///< T* of the nearest point of its input box
  Eigen::MatrixXd exported_z, exported_x_hat;
};

/// Runs `options.samples` replay inputs, quiet enough that at least half of them stay in the domain where that can be.
/// Throws Error when the model cannot be exported so.
ReplayRun run_replay(const Model& model, const ExportOptions& options);

}  // namespace nlo::codegen
