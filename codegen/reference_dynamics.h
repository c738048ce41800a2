// SPDX-License-Identifier: MIT
// How the latent state of each structure runs between two samples: the equations of codegen/model.h with dynamic sizes
// and nothing folded. What ReferenceObserver steps.
#pragma once

#include <nlo/explicit_rk.h>
#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <variant>

#include "codegen/latent_step.h"
#include "codegen/model.h"
#include "codegen/reference_network.h"

namespace nlo::codegen {

/// What acts on the latent state from one sample to the next.
template <class Scalar>
struct Between {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const Vector &y, &y_next;  ///< n_y
  const Vector &u, &u_next;  ///< n_u; empty unless driven
};

template <class Vector, class Scalar>
Vector held(Hold hold, const Vector& from, const Vector& to, Scalar part) {
  if (hold == Hold::kZeroOrder) return from;
  return (Scalar(1) - part) * from + part * to;
}

/// z+ = z + (A - I) z + B0 y_k + B1 y_{k+1}.
template <class Scalar>
class KklDynamics {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  explicit KklDynamics(const Model& m) : nominal_(m, latent_step(m, m.sample_period_s)), last_(nominal_) {
    last_dt_s_ = m.sample_period_s;
  }

  /// Coefficients of the latest other step are kept: logs have few different ones in a row.
  void advance(const Model& m, Vector& z, const Between<Scalar>& over, double dt_s) {
    if (dt_s != m.sample_period_s && dt_s != last_dt_s_) {
      last_ = Coefficients(m, latent_step(m, dt_s));
      last_dt_s_ = dt_s;
    }
    (dt_s == m.sample_period_s ? nominal_ : last_).advance(z, over.y, over.y_next);
  }

  struct Coefficients {
    Coefficients(const Model& m, const LatentStep& step)
        : a_minus_identity(block_diagonal(m, step.a_minus_1).template cast<Scalar>()),
          b0(step.b0.template cast<Scalar>()),
          b1(step.b1.template cast<Scalar>()) {}
    void advance(Vector& z, const Vector& y, const Vector& y_next) const {
      z += (a_minus_identity * z + b0 * y + b1 * y_next).eval();
    }
    Matrix a_minus_identity, b0, b1;
  };

 private:
  Coefficients nominal_, last_;
  double last_dt_s_ = 0.0;
};

/// (24)-(25): D z + F y exactly, phi(z) u by the scheme of nlo/exponential_rk.h.
template <class Scalar>
class DrivenDynamics {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  DrivenDynamics(const Model& m, Activations activations)
      : nominal_(m, m.sample_period_s),
        inverse_map_(m.inverse_map, activations),
        forward_map_(m.drive->forward_map, activations),
        field_weights_(m.drive->input_field.weights.cast<Scalar>()),
        field_bias_(m.drive->input_field.bias.cast<Scalar>()) {}

  void advance(const Model& m, Vector& z, const Between<Scalar>& over, double dt_s) {
    if (dt_s == m.sample_period_s) return advance_by(m, nominal_, 1, z, over);
    const int pieces = pieces_of(dt_s, m.sample_period_s);
    advance_by(m, Step(m, dt_s / pieces), pieces, z, over);
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
    typename KklDynamics<Scalar>::Coefficients full, half;
    ForcedWeights<Matrix> weights;
  };

  void advance_by(const Model& m, const Step& step, int pieces, Vector& z, const Between<Scalar>& over) const {
    const Hold hold = hold_named(m.hold), input_hold = hold_named(m.drive->input_hold);
    const ForcedWeights<Matrix>& w = step.weights;
    for (int i = 0; i < pieces; ++i) {
      const auto part = [&](double c) { return static_cast<Scalar>((i + c) / pieces); };
      const auto y = [&](double c) { return held(hold, over.y, over.y_next, part(c)); };
      const auto u = [&](double c) -> Vector {
        return input_hold == Hold::kZeroOrder ? over.u_next : held(input_hold, over.u, over.u_next, part(c));
      };
      Vector half = z, full = z;
      step.half.advance(half, y(0.0), y(0.5));
      step.full.advance(full, y(0.0), y(1.0));
      const Vector n1 = drive(m, z, y(0.0), u(0.0));
      const Vector n2 = drive(m, half + w.stage2 * n1, y(0.5), u(0.5));
      const Vector n3 = drive(m, half + w.stage3_1 * n1 + w.stage3_2 * n2, y(0.5), u(0.5));
      const Vector n4 = drive(m, full + w.stage4_1 * n1 + w.stage4_3 * n3, y(1.0), u(1.0));
      z = full + w.end_1 * n1 + w.end_23 * (n2 + n3) + w.end_4 * n4;
    }
  }

  /// phi(z) u = dT/dx(x_hat) g(x_hat) u, x_hat = T*(z, y).
  Vector drive(const Model& m, const Vector& z, const Vector& y, const Vector& u) const {
    Vector in(z.size() + y.size());
    in << z, y;
    const Vector x_hat = inverse_map_(in);
    const Vector field = field_weights_ * x_hat + field_bias_;
    return forward_map_.jvp(x_hat, Eigen::Map<const Matrix>(field.data(), m.nx(), m.nu()) * u);
  }

  Step nominal_;
  ReferenceNetwork<Scalar> inverse_map_, forward_map_;
  Matrix field_weights_;
  Vector field_bias_;
};

/// (15) and (11): z' = slope(z, y) by RK4.
template <class Scalar>
class NonlinearDynamics {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  NonlinearDynamics(const Model& m, Activations activations)
      : network_(m.luenberger ? m.luenberger->nonlinearity : *m.dynamics, activations) {
    if (!m.luenberger) return;
    state_matrix_ = m.luenberger->state_matrix.cast<Scalar>();
    output_matrix_ = m.luenberger->output_matrix.cast<Scalar>();
    gain_ = m.luenberger->gain.cast<Scalar>();
  }

  void advance(const Model& m, Vector& z, const Between<Scalar>& over, double dt_s) const {
    const Hold hold = hold_named(m.hold);
    const int pieces = pieces_of(dt_s, m.sample_period_s);
    const auto h = static_cast<Scalar>(dt_s / pieces);
    for (int i = 0; i < pieces; ++i) {
      const auto y = [&](double c) { return held(hold, over.y, over.y_next, static_cast<Scalar>((i + c) / pieces)); };
      const Vector k1 = slope(z, y(0.0));
      const Vector k2 = slope(z + h / 2 * k1, y(0.5));
      const Vector k3 = slope(z + h / 2 * k2, y(0.5));
      const Vector k4 = slope(z + h * k3, y(1.0));
      z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }

 private:
  Vector slope(const Vector& z, const Vector& y) const {
    if (state_matrix_.size() != 0) return state_matrix_ * z + network_(z) + gain_ * (y - output_matrix_ * z);
    Vector in(z.size() + y.size());
    in << z, y;
    return network_(in);
  }

  ReferenceNetwork<Scalar> network_;
  Matrix state_matrix_, output_matrix_, gain_;
};

/// The dynamics of a model's structure: advance(model, z, between, dt_s).
template <class Scalar>
using ReferenceDynamics = std::variant<KklDynamics<Scalar>, DrivenDynamics<Scalar>, NonlinearDynamics<Scalar>>;

template <class Scalar>
ReferenceDynamics<Scalar> reference_dynamics(const Model& m, Activations activations) {
  if (m.drive) return DrivenDynamics<Scalar>(m, activations);
  if (m.luenberger || m.dynamics) return NonlinearDynamics<Scalar>(m, activations);
  return KklDynamics<Scalar>(m);
}

}  // namespace nlo::codegen
