// SPDX-License-Identifier: MIT
// Causal estimates without an observer: the training mean, the sensor of a state itself, the difference of the last two
// measurements, the end of a polynomial through the last few, or a regression on the last few samples of all channels
// and their products. An observer that does not beat them is not needed.
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

/// The best sensor of a state among outputs in its unit, by their RMSE as they are (infinite: in another unit) and the
/// state's deviation; -1: there is none, one is the truth itself, or the mean is nearer. A sensor without any noise is
/// a simulated one: it says nothing of a real one.
int best_sensor(const std::vector<double>& errors, double deviation);

class LogBaseline {
 public:
  static const std::vector<std::string>& names();  ///< constant, sensor, difference, polynomial, static_ridge

  /// Fits the baseline called `name` to the training logs: the states' means; for each state the output
  /// in its unit, or the polynomial (degree 1 to 3, up to 48 samples; judged at some 20,000 of their samples), of the
  /// smallest RMSE; the weights of static_ridge.h. Give it the outputs as the observer will see them, noise included.
  /// `sources` is LogSchema::state_sources. Throws codegen::Error for an unknown name.
  static LogBaseline fit(std::string_view name, const Dataset& training, const std::vector<StateSource>& sources);

  /// n_x x N; the rows of states to which it does not apply are NaN.
  Eigen::MatrixXd estimate(const Trajectory& run) const;

  /// A hidden state has no measurement to difference; "sensor" is of states with an output in their unit that is not
  /// the truth itself.
  bool applies(int state) const;

  /// Multiply-adds of one sample for all states.
  Eigen::Index multiply_adds() const;

  /// "constant", or for instance "polynomial (degree 2, 7 samples)".
  std::string describe(int state) const;

 private:
  std::string name_;
  std::vector<StateSource> sources_;
  Eigen::VectorXd mean_;
  std::vector<EndPointPolynomial> polynomials_;  ///< one per state, of "difference" and "polynomial"; else empty
  std::vector<int> sensors_;                     ///< likewise of "sensor": the output, or -1
  std::vector<std::string> sensor_names_;        ///< likewise
  std::optional<StaticRidge> ridge_;             ///< regression of "static_ridge"
};

}  // namespace nlo::trainer
