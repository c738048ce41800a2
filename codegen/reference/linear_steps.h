// SPDX-License-Identifier: MIT
// Steps of the linear latent system: z+ = z + (A - I) z + B0 y_k + B1 y_{k+1}.
#pragma once

#include <Eigen/Core>

#include "codegen/model/latent_step.h"
#include "codegen/model/model.h"
#include "codegen/reference/dynamics.h"

namespace nlo::codegen {

/// Coefficients of one step, rounded to Scalar.
template <class Scalar>
struct LinearStep {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  LinearStep(const Model& model, const StepMatrices& step);
  void advance(Vector& z, const Vector& y, const Vector& y_next) const;

  Matrix a_minus_identity, b0, b1;
};

/// Steps D, F and S of a model. Keeps the coefficients of the latest step that differed from the sample period, because
/// successive steps of a log are often equal.
template <class Scalar>
class LinearSteps {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// `model` must outlive this object.
  explicit LinearSteps(const Model& model);

  void start(Matrix& z, const Matrix& y) const;
  void advance(Vector& z, const Between<Scalar>& over, double dt_s);
  Matrix slope(const Matrix& z, const Matrix& y) const;

 private:
  const Model& model_;
  LinearStep<Scalar> nominal_, last_;
  double last_dt_s_ = 0.0;
  Matrix d_, injection_, steady_gain_;
};

extern template struct LinearStep<float>;
extern template struct LinearStep<double>;
extern template class LinearSteps<float>;
extern template class LinearSteps<double>;

}  // namespace nlo::codegen
