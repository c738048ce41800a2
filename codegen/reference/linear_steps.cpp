// SPDX-License-Identifier: MIT
#include "codegen/reference/linear_steps.h"

namespace nlo::codegen {

template <class Scalar>
LinearStep<Scalar>::LinearStep(const Model& m, const StepMatrices& step)
    : a_minus_identity(block_diagonal(m, step.a_minus_1).template cast<Scalar>()),
      b0(step.b0.template cast<Scalar>()),
      b1(step.b1.template cast<Scalar>()) {}

template <class Scalar>
void LinearStep<Scalar>::advance(Vector& z, const Vector& y, const Vector& y_next) const {
  z += (a_minus_identity * z + b0 * y + b1 * y_next).eval();
}

template <class Scalar>
LinearSteps<Scalar>::LinearSteps(const Model& m)
    : model_(m),
      nominal_(m, latent_step(m, m.sample_period_s)),
      last_(nominal_),
      last_dt_s_(m.sample_period_s),
      d_(block_diagonal(m, linear_latent(m)->eigenvalues).template cast<Scalar>()),
      injection_(linear_latent(m)->output_injection.template cast<Scalar>()),
      steady_gain_(steady_gain(m).template cast<Scalar>()) {}

template <class Scalar>
void LinearSteps<Scalar>::start(Matrix& z, const Matrix& y) const {
  if (linear_latent(model_)->starts_steady) z += steady_gain_ * y;
}

template <class Scalar>
void LinearSteps<Scalar>::advance(Vector& z, const Between<Scalar>& over, double dt_s) {
  if (dt_s != model_.sample_period_s && dt_s != last_dt_s_) {
    last_ = LinearStep<Scalar>(model_, latent_step(model_, dt_s));
    last_dt_s_ = dt_s;
  }
  (dt_s == model_.sample_period_s ? nominal_ : last_).advance(z, over.y, over.y_next);
}

template <class Scalar>
auto LinearSteps<Scalar>::slope(const Matrix& z, const Matrix& y) const -> Matrix {
  return d_ * z + injection_ * y;
}

template struct LinearStep<float>;
template struct LinearStep<double>;
template class LinearSteps<float>;
template class LinearSteps<double>;

}  // namespace nlo::codegen
