// SPDX-License-Identifier: MIT
// Causal estimates without an observer, which an observer must beat to be useful: the training mean; the sensor of a
// state; the difference of the last two measurements; the end of a polynomial through the last measurements; or a
// regression on the last samples of all channels and their products.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/static_ridge.h"

namespace nlo::trainer {

/// The end of the polynomial of `degree` through the last `samples` measurements, by least squares. At the start of a
/// log there are fewer samples, and the degree is lower.
struct EndPointPolynomial {
  int samples = 2;
  int degree = 1;
};

/// Returns the value (`derivative` 0) or slope (1) of the end-point polynomial at every sample, N, or at every
/// `stride`-th from the first on. Its windows contain neighbouring samples with their exact time stamps.
Eigen::VectorXd end_point_estimate(const EndPointPolynomial& polynomial, int derivative, const Eigen::VectorXd& time_s,
                                   const Eigen::VectorXd& measured, Eigen::Index stride = 1);

/// Returns the mean of each state over the samples whose truth counts, n_x. For an angle it is the direction of the
/// mean sine and cosine: -pi and pi average to pi, not to 0.
Eigen::VectorXd mean_states(const Dataset& dataset);

/// Returns the output that is the best sensor of a state: the smallest RMSE among the outputs in the state's unit
/// (`errors`; infinite for other units). Returns -1 if there is no such output, if an output is the truth itself (a
/// simulated sensor without noise), or if the state's mean has a smaller error (`deviation`).
int best_sensor(const std::vector<double>& errors, double deviation);

class LogBaseline {
 public:
  static const std::vector<std::string>& names();  ///< constant, sensor, difference, polynomial, static_ridge

  /// Fits the baseline called `name` to the training logs. It is the mean of each state; or for each state the output
  /// in the state's unit or the polynomial with the smallest RMSE; or the weights of static_ridge.h. Polynomials have
  /// degree 1 to 3 and up to 48 samples; some 20,000 samples decide. Pass the outputs that the observer gets, noise
  /// included. `sources` is LogSchema::state_sources. Throws codegen::Error for an unknown name.
  static LogBaseline fit(std::string_view name, const Dataset& training, const std::vector<StateSource>& sources);

  /// Returns estimates, n_x x N; NaN in the rows of states to which the baseline does not apply.
  Eigen::MatrixXd estimate(const Trajectory& run) const;

  /// Returns true if the baseline applies to a state. A hidden state has no measurement to differentiate; "sensor"
  /// needs an output in the unit of the state that is not the truth itself.
  bool applies(int state) const;

  /// Returns the multiply-adds of one sample for all states.
  Eigen::Index multiply_adds() const;

  /// Returns "constant", or for instance "polynomial (degree 2, 7 samples)".
  std::string describe(int state) const;

 private:
  std::string name_;
  std::vector<StateSource> sources_;
  Eigen::VectorXd mean_;
  std::vector<EndPointPolynomial> polynomials_;  ///< one per state, for "difference" and "polynomial"; else empty
  std::vector<int> sensors_;                     ///< the output for each state, for "sensor"; -1: none
  std::vector<std::string> sensor_names_;        ///< names of these outputs
  std::optional<StaticRidge> ridge_;             ///< regression of "static_ridge"
};

}  // namespace nlo::trainer
