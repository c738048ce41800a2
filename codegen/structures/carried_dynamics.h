// SPDX-License-Identifier: MIT
// Steps carried vectors between two samples (nlo/carried_observer.h), by Rodrigues' formula and the latent system of
// one component for each of them.
#pragma once

#include <nlo/carried_observer.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "codegen/model/field_checks.h"
#include "codegen/reference/linear_steps.h"

namespace nlo::codegen {

/// Returns D and F of one component as a KKL observer, whose output is as large as the length of the vectors. The
/// bounds of its z are bounds of the length of the vectors that its modes carry.
inline Model component_of(const Model& m) {
  const Carried& own = std::get<Carried>(m.structure);
  Model one;
  one.name = m.name;
  one.outputs = {m.outputs.front()};
  one.sample_period_s = m.sample_period_s;
  one.hold = m.hold;
  one.initial_latent = Eigen::VectorXd::Zero(own.component.eigenvalues.size());
  const Eigen::VectorXd largest = largest_readings(m);
  double length = 0.0;
  for (int j = 0; j + kAxes <= m.ny(); j += kAxes) length = std::max(length, largest.segment<kAxes>(j).norm());
  one.output_max = Eigen::VectorXd::Constant(1, length);
  one.output_min = -one.output_max;
  one.structure = Kkl{own.component, {}};
  return one;
}

template <class Scalar>
class CarriedDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  explicit CarriedDynamics(const Model& m)
      : component_(component_of(m)),
        latent_(component_),
        ny_(m.ny()),
        sample_period_s_(m.sample_period_s),
        unit_length_(std::get<Carried>(m.structure).unit_length) {}

  void start(Matrix& z, const Matrix& y, const std::vector<bool>*) const override {
    for (Eigen::Index j = 0; j < ny_; ++j) {
      Matrix own = rows(z, j);
      latent_.start(own, y.row(j));
      rows(z, j) = own;
    }
  }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    const Axes rotation = rotation_over(over.y.segment(ny_, kAxes), over.y_next.segment(ny_, kAxes), dt_s);
    const Eigen::Index modes = z.size() / ny_;
    for (Eigen::Index j = 0; j < ny_; j += kAxes) {
      Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, kAxes>> carried(z.data() + j * modes, modes, kAxes);
      carried = (carried * rotation.transpose()).eval();
      const Vector last = rotation * over.y.segment(j, kAxes);
      for (Eigen::Index c = 0; c < kAxes; ++c) {
        Vector own = carried.col(c);
        const Vector from = last.segment(c, 1), to = over.y_next.segment(j + c, 1), none;
        latent_.advance(own, {from, to, none, none}, dt_s);
        carried.col(c) = own;
      }
    }
  }
  double longest_step_s() const override { return CarriedLimits::kLongestGap * sample_period_s_; }

  Matrix slope(const Matrix& z, const Matrix& y, const Vector&) const override {
    Matrix slope(z.rows(), z.cols());
    for (Eigen::Index j = 0; j < ny_; ++j) {
      rows(slope, j) = latent_.slope(rows(z, j), y.row(j));
      const Eigen::Index first = j / kAxes * kAxes, a = (j + 1) % kAxes,
                         b = (j + 2) % kAxes;  // (w x z)_c = w_a z_b - w_b z_a
      rows(slope, j) -= rows(z, first + b) * y.row(ny_ + a).asDiagonal();
      rows(slope, j) += rows(z, first + a) * y.row(ny_ + b).asDiagonal();
    }
    return slope;
  }

  void finish(Matrix& x_hat) const override {
    if (!unit_length_) return;
    for (Eigen::Index k = 0; k < x_hat.cols(); ++k)
      for (Eigen::Index i = 0; i < x_hat.rows(); i += kAxes) {
        const Scalar length = x_hat.col(k).segment(i, kAxes).stableNorm();
        if (length > Scalar(0)) x_hat.col(k).segment(i, kAxes) /= length;
      }
  }

 private:
  using Axes = Eigen::Matrix<Scalar, kAxes, kAxes>;
  using Axis = Eigen::Matrix<Scalar, kAxes, 1>;

  /// Returns exp(-[theta]x) by Rodrigues' formula, with theta as in nlo/rotation.h.
  static Axes rotation_over(const Axis& w, const Axis& w_next, double dt_s) {
    const auto h = static_cast<Scalar>(dt_s);
    const Axis theta = h / 2 * (w + w_next) + h * h / 12 * w.cross(w_next);
    const Scalar angle = theta.norm();
    Axes cross;
    cross << 0, -theta.z(), theta.y(), theta.z(), 0, -theta.x(), -theta.y(), theta.x(), 0;
    if (!(angle > Scalar(0))) return Axes::Identity();
    const Scalar half = std::sin(angle / 2) / angle;
    return Axes::Identity() - std::sin(angle) / angle * cross + 2 * half * half * cross * cross;
  }

  /// Returns the rows of component j of the outputs.
  auto rows(Matrix& z, Eigen::Index j) const { return z.middleRows(j * (z.rows() / ny_), z.rows() / ny_); }
  auto rows(const Matrix& z, Eigen::Index j) const { return z.middleRows(j * (z.rows() / ny_), z.rows() / ny_); }

  const Model component_;
  LinearSteps<Scalar> latent_;
  Eigen::Index ny_;
  double sample_period_s_;
  bool unit_length_;
};

}  // namespace nlo::codegen
