// SPDX-License-Identifier: MIT
// What a user would do without an observer, all of it causal: predict the training mean, difference the last two
// measurements, or fit a polynomial to the last few and read its end. An observer that does not beat these is not
// needed.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// The end of the polynomial of `degree` through the last `samples` measurements, by least squares; fewer, and a lower
/// degree, at the start of a log.
struct EndPointPolynomial {
  int samples = 2;
  int degree = 1;
};

/// Value (`derivative` 0) or slope (1) of the end-point polynomial at every sample, N, or at every `stride`-th from the
/// first on; its windows hold neighbouring samples with their exact time stamps.
Eigen::VectorXd end_point_estimate(const EndPointPolynomial& polynomial, int derivative, const Eigen::VectorXd& time_s,
                                   const Eigen::VectorXd& measured, Eigen::Index stride = 1);

/// n_x: mean of each state where the truth counts. That of an angle is the direction of its mean sine and cosine: -pi
/// and pi average to pi, not to 0.
Eigen::VectorXd mean_states(const Dataset& dataset);

class LogBaseline {
 public:
  static const std::vector<std::string>& names();  ///< constant, difference, polynomial

  /// Learns what the baseline called `name` needs from the training logs: the states' means, or for each state the
  /// polynomial of the smallest RMSE (degree 1 to 3, up to 48 samples; judged at some 20,000 of their samples). Give it
  /// the outputs as the observer will see them, noise included. `sources` is LogSchema::state_sources. Throws
  /// codegen::Error for an unknown name.
  static LogBaseline fit(std::string_view name, const Dataset& training, const std::vector<StateSource>& sources);

  /// n_x x N; the rows of states to which it does not apply are NaN.
  Eigen::MatrixXd estimate(const Trajectory& run) const;

  /// A hidden state has no measurement to difference: only "constant" applies to it.
  bool applies(int state) const;

  /// "constant", or for instance "polynomial (degree 2, 7 samples)".
  std::string describe(int state) const;

 private:
  std::string name_;
  std::vector<StateSource> sources_;
  Eigen::VectorXd mean_;
  std::vector<EndPointPolynomial> polynomials_;  ///< one per state; empty for "constant"
};

}  // namespace nlo::trainer
