// SPDX-License-Identifier: MIT
// The equations of codegen/model.h as they stand there, with dynamic sizes and nothing folded: the oracle that exports
// are tested against (double) and what `nlo evaluate` runs over whole trajectories (float).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "codegen/latent_step.h"
#include "codegen/model.h"
#include "codegen/reference_network.h"
#include "codegen/validate.h"

namespace nlo::codegen {

/// The observer's answers over one trajectory of N samples.
struct Run {
  Eigen::MatrixXd x_hat;  ///< n_x x N
  Eigen::MatrixXd z;      ///< n_z x N
};

template <class Scalar>
class ReferenceObserver {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the model. Throws Error unless it is valid (see validate.h).
  explicit ReferenceObserver(const Model& model)
      : model_(validated(model)),
        nominal_(coefficients(model.sample_period_s)),
        steady_gain_(codegen::steady_gain(model).cast<Scalar>()),
        inverse_map_(model.inverse_map) {
    reset();
  }

  /// z = initial latent; the next sample is the first.
  void reset() {
    z_ = model_.initial_latent.cast<Scalar>();
    y_ = Eigen::VectorXd::Zero(model_.ny());
    started_ = false;
  }

  /// One sample period with the outputs `y` (n_y). An entry that is not finite, or an angle out of its range, keeps its
  /// last good value; others are clamped to their range. Before the first sample that is good in all entries, nothing
  /// happens.
  void step(const Eigen::VectorXd& y) { take(accepted(y, true), nominal_); }

  /// The same over `dt_s` since the last sample.
  void step(const Eigen::VectorXd& y, double dt_s) { take(accepted(y, true), coefficients(dt_s)); }

  /// x_hat, n_x.
  Vector estimate() const { return inverse_map(z_, y_.cast<Scalar>()); }

  /// z, n_z. Angles are unwrapped from the first sample on, and z with them: subtract steady_gain() times the turns to
  /// compare with an observer that turns z back.
  const Vector& latent() const { return z_; }

  /// The outputs as the last step took them, n_y: held, clamped, angles unwrapped.
  const Eigen::VectorXd& output() const { return y_; }

  /// A whole trajectory from reset: `outputs` n_y x N with angles unwrapped, `time_s` N. With `uniform` each step is
  /// the sample period, else it is the difference of the time stamps. T* is evaluated as matrix products over blocks of
  /// samples.
  Run run(const Eigen::MatrixXd& outputs, const Eigen::VectorXd& time_s, bool uniform) {
    const Eigen::Index samples = outputs.cols();
    Run run{Eigen::MatrixXd(model_.nx(), samples), Eigen::MatrixXd(model_.nz(), samples)};
    Matrix z(model_.nz(), samples), y(model_.ny(), samples);
    reset();
    Coefficients last = nominal_;
    double last_dt_s = model_.sample_period_s;
    for (Eigen::Index k = 0; k < samples; ++k) {
      const double dt_s = uniform || k == 0 ? model_.sample_period_s : time_s(k) - time_s(k - 1);
      if (dt_s != last_dt_s) {
        last = coefficients(dt_s);
        last_dt_s = dt_s;
      }
      take(accepted(outputs.col(k), false), last);
      z.col(k) = z_;
      y.col(k) = y_.cast<Scalar>();
    }
    run.x_hat = estimates_in_blocks(z, y);
    run.z = z.template cast<double>();
    return run;
  }

  /// x_hat (n_x x N) for the columns of z (n_z x N) and y (n_y x N), wherever they come from.
  Eigen::MatrixXd estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const {
    return estimates_in_blocks(z.cast<Scalar>(), y.cast<Scalar>());
  }

 private:
  struct Coefficients {
    Matrix a_minus_identity, b0, b1;
  };

  Coefficients coefficients(double dt_s) const {
    const LatentStep step = latent_step(model_, dt_s);
    return {a_minus_identity(model_, step).template cast<Scalar>(), step.b0.template cast<Scalar>(),
            step.b1.template cast<Scalar>()};
  }

  static const Model& validated(const Model& model) {
    validate(model);
    return model;
  }

  /// `y` with faults mended and angles continued from the last sample; y_ itself when it cannot be used.
  Eigen::VectorXd accepted(const Eigen::VectorXd& y, bool wrapped) const {
    Eigen::VectorXd good = y;
    for (int j = 0; j < model_.ny(); ++j) {
      const double wrap = model_.outputs[static_cast<std::size_t>(j)].wrap;
      const double low = model_.output_min(j), high = model_.output_max(j);
      if (wrap == 0.0) {
        if (std::isfinite(y(j))) good(j) = std::clamp(y(j), low, high);
      } else if (wrapped) {
        if (y(j) < low || y(j) > high) good(j) = std::nan("");
        good(j) -= wrap * std::round((good(j) - y_(j)) / wrap);
      }
      if (!std::isfinite(good(j)) && started_) good(j) = y_(j);
    }
    return good;
  }

  void take(const Eigen::VectorXd& y, const Coefficients& c) {
    if (!y.allFinite()) return;  // before the first good sample
    if (!started_) {
      if (model_.starts_steady) z_ += steady_gain_ * y.cast<Scalar>();
    } else {
      z_ += (c.a_minus_identity * z_ + c.b0 * y_.cast<Scalar>() + c.b1 * y.cast<Scalar>()).eval();
    }
    y_ = y;
    started_ = true;
  }

  /// T* as matrix products over blocks of samples.
  Eigen::MatrixXd estimates_in_blocks(const Matrix& z, const Matrix& y) const {
    constexpr Eigen::Index kBlock = 512;  // 50 neurons x 512 floats: a layer's input and output stay in the L2 cache
    Eigen::MatrixXd x_hat(model_.nx(), z.cols());
    for (Eigen::Index k = 0; k < z.cols(); k += kBlock) {
      const Eigen::Index n = std::min(kBlock, z.cols() - k);
      x_hat.middleCols(k, n) = inverse_map(z.middleCols(k, n), y.middleCols(k, n)).template cast<double>();
    }
    return x_hat;
  }

  /// x_hat for each column of z (n_z x B) and y (n_y x B).
  Matrix inverse_map(const Matrix& z, const Matrix& y) const {
    Matrix inputs(z.rows() + y.rows(), z.cols());
    inputs << z, y;
    return inverse_map_(inputs);
  }

  Model model_;
  Coefficients nominal_;
  Matrix steady_gain_;
  ReferenceNetwork<Scalar> inverse_map_;

  Vector z_;
  Eigen::VectorXd y_;
  bool started_ = false;
};

}  // namespace nlo::codegen
