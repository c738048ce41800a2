// SPDX-License-Identifier: MIT
#include "codegen/model/latent_step.h"

#include <nlo/latent.h>

namespace nlo::codegen {
namespace {

StepMatrices discretised(const Model& m, Hold hold, double dt_s) {
  const LinearLatent& latent = *linear_latent(m);
  const Eigen::MatrixXd& f = latent.output_injection;
  const Eigen::VectorXd& eigenvalues = latent.eigenvalues;
  StepMatrices step{Eigen::VectorXd(m.nz()), Eigen::MatrixXd(m.nz(), m.nr()), Eigen::MatrixXd(m.nz(), m.nr())};
  for (int r = 0; r < 2 * latent.pairs; r += 2) {
    const auto mode = discretise(hold, Complex<double>{eigenvalues(r), eigenvalues(r + 1)}, dt_s);
    step.a_minus_1.segment<2>(r) << mode.a_minus_1.re, mode.a_minus_1.im;
    step.b0.row(r) = mode.b0.re * f.row(r) - mode.b0.im * f.row(r + 1);
    step.b0.row(r + 1) = mode.b0.im * f.row(r) + mode.b0.re * f.row(r + 1);
    step.b1.row(r) = mode.b1.re * f.row(r) - mode.b1.im * f.row(r + 1);
    step.b1.row(r + 1) = mode.b1.im * f.row(r) + mode.b1.re * f.row(r + 1);
  }
  for (int r = 2 * latent.pairs; r < m.nz(); ++r) {
    const auto mode = discretise(hold, Complex<double>{eigenvalues(r), 0.0}, dt_s);
    step.a_minus_1(r) = mode.a_minus_1.re;
    step.b0.row(r) = mode.b0.re * f.row(r);
    step.b1.row(r) = mode.b1.re * f.row(r);
  }
  return step;
}

}  // namespace

StepMatrices latent_step(const Model& m, double dt_s) {
  const bool exact = m.hold == Hold::kRk4 && dt_s != m.sample_period_s;
  return discretised(m, exact ? Hold::kFirstOrder : m.hold, dt_s);
}

ForcedStepMatrices forced_latent_step(const Model& m, double dt_s) {
  const LinearLatent& latent = *linear_latent(m);
  ForcedStepMatrices step{discretised(m, m.hold == Hold::kRk4 ? Hold::kFirstOrder : m.hold, 0.5 * dt_s), {}};
  for (int r = 0; r < m.nz(); ++r) {
    const bool paired = r < 2 * latent.pairs;
    const auto mode =
        forced_weights(Complex<double>{latent.eigenvalues(r), paired ? latent.eigenvalues(r + 1) : 0.0}, dt_s);
    const auto set = [&](Eigen::VectorXd& weights, const Complex<double>& value) {
      weights.conservativeResize(m.nz());
      weights(r) = value.re;
      if (paired) weights(r + 1) = value.im;
    };
    auto& w = step.weights;
    set(w.stage2, mode.stage2);
    set(w.stage3_1, mode.stage3_1);
    set(w.stage3_2, mode.stage3_2);
    set(w.stage4_1, mode.stage4_1);
    set(w.stage4_3, mode.stage4_3);
    set(w.end_1, mode.end_1);
    set(w.end_23, mode.end_23);
    set(w.end_4, mode.end_4);
    if (paired) ++r;
  }
  return step;
}

Eigen::MatrixXd block_diagonal(const Model& m, const Eigen::VectorXd& modes) {
  Eigen::MatrixXd matrix = modes.asDiagonal();
  for (int r = 0; r < 2 * linear_latent(m)->pairs; r += 2) {
    const double re = modes(r), im = modes(r + 1);
    matrix.block<2, 2>(r, r) << re, -im, im, re;
  }
  return matrix;
}

Eigen::MatrixXd steady_gain(const Model& m) {
  if (linear_latent(m) == nullptr) return Eigen::MatrixXd::Zero(m.nz(), m.nr());
  const auto& [pairs, eigenvalues, injection, starts_steady, relative] = *linear_latent(m);
  Eigen::MatrixXd gain(injection.rows(), injection.cols());
  for (int p = 0; p < pairs; ++p) {
    const double re = eigenvalues(2 * p), im = eigenvalues(2 * p + 1), square = re * re + im * im;
    const auto f_re = injection.row(2 * p), f_im = injection.row(2 * p + 1);
    gain.row(2 * p) = -(re * f_re + im * f_im) / square;
    gain.row(2 * p + 1) = -(re * f_im - im * f_re) / square;
  }
  for (Eigen::Index i = 2 * pairs; i < eigenvalues.size(); ++i) gain.row(i) = -injection.row(i) / eigenvalues(i);
  return gain.array() + 0.0;  // -0 becomes 0
}

}  // namespace nlo::codegen
