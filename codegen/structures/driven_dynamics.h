// SPDX-License-Identifier: MIT
// The equations of codegen/model/driven_kkl.h with dynamic sizes and without folding.
#pragma once

#include <nlo/explicit_rk.h>

#include "codegen/model/latent_step.h"
#include "codegen/reference/integrate.h"
#include "codegen/reference/linear_steps.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

/// Steps D z + F y exactly, and phi(z) u by the scheme of nlo/exponential_rk.h.
template <class Scalar>
class DrivenDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  DrivenDynamics(const Model& m, Activations activations)
      : model_(m),
        hold_(m.hold),
        input_hold_(own_part<DrivenKkl>(m).input_hold),
        latent_(m),
        nominal_(m, m.sample_period_s),
        inverse_map_(own_part<DrivenKkl>(m).inverse_map, activations),
        forward_map_(own_part<DrivenKkl>(m).forward_map, activations),
        field_weights_(own_part<DrivenKkl>(m).input_field.weights.cast<Scalar>()),
        field_bias_(own_part<DrivenKkl>(m).input_field.bias.cast<Scalar>()) {}

  void start(Matrix& z, const Matrix& y, const std::vector<bool>*) const override { latent_.start(z, y); }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    if (dt_s == model_.sample_period_s) return advance_by(nominal_, 1, z, over);
    const int pieces = pieces_of(dt_s, model_.sample_period_s);
    advance_by(Step(model_, dt_s / pieces), pieces, z, over);
  }

  double longest_step_s() const override { return kMostPieces * model_.sample_period_s; }

  Matrix slope(const Matrix& z, const Matrix& y, const Vector& u) const override {
    Matrix slope = latent_.slope(z, y);
    for (Eigen::Index i = 0; u.size() != 0 && i < z.cols(); ++i) slope.col(i) += drive(z.col(i), y.col(i), u);
    return slope;
  }

 private:
  struct Step {
    Step(const Model& m, double h) : full(m, latent_step(m, h)), half(m, forced_latent_step(m, h).half) {
      const auto matrix = [&m](const Eigen::VectorXd& modes) -> Matrix {
        return block_diagonal(m, modes).template cast<Scalar>();
      };
      const auto w = forced_latent_step(m, h).weights;
      weights = {matrix(w.stage2),   matrix(w.stage3_1), matrix(w.stage3_2), matrix(w.stage4_1),
                 matrix(w.stage4_3), matrix(w.end_1),    matrix(w.end_23),   matrix(w.end_4)};
    }
    LinearStep<Scalar> full, half;
    ForcedWeights<Matrix> weights;
  };

  void advance_by(const Step& step, int pieces, Vector& z, const Between<Scalar>& over) const {
    const ForcedWeights<Matrix>& w = step.weights;
    for (int i = 0; i < pieces; ++i) {
      const auto part = [&](double c) { return static_cast<Scalar>((i + c) / pieces); };
      const auto y = [&](double c) { return held(hold_, over.y, over.y_next, part(c)); };
      const auto u = [&](double c) -> Vector {
        return input_hold_ == Hold::kZeroOrder ? over.u_next : held(input_hold_, over.u, over.u_next, part(c));
      };
      Vector half = z, full = z;
      step.half.advance(half, y(0.0), y(0.5));
      step.full.advance(full, y(0.0), y(1.0));
      const Vector n1 = drive(z, y(0.0), u(0.0));
      const Vector n2 = drive(half + w.stage2 * n1, y(0.5), u(0.5));
      const Vector n3 = drive(half + w.stage3_1 * n1 + w.stage3_2 * n2, y(0.5), u(0.5));
      const Vector n4 = drive(full + w.stage4_1 * n1 + w.stage4_3 * n3, y(1.0), u(1.0));
      z = full + w.end_1 * n1 + w.end_23 * (n2 + n3) + w.end_4 * n4;
    }
  }

  /// Returns phi(z) u = dT/dx(x_hat) g(x_hat) u, x_hat = T*(z, y).
  Vector drive(const Vector& z, const Vector& y, const Vector& u) const {
    const Vector x_hat = inverse_map_(stacked<Scalar>(z, y));
    const Vector field = field_weights_ * x_hat + field_bias_;
    return forward_map_.jvp(x_hat, field.reshaped(x_hat.size(), u.size()) * u);
  }

  const Model& model_;
  Hold hold_, input_hold_;
  LinearSteps<Scalar> latent_;
  Step nominal_;
  ReferenceNetwork<Scalar> inverse_map_, forward_map_;
  Matrix field_weights_;
  Vector field_bias_;
};

}  // namespace nlo::codegen
