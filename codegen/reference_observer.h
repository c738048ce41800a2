// SPDX-License-Identifier: MIT
// The equations of codegen/model.h as they stand there, with dynamic sizes and nothing folded: the oracle that exports
// are tested against (double) and what `nlo evaluate` runs over whole trajectories (float).
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "codegen/error.h"
#include "codegen/latent_step.h"
#include "codegen/model.h"
#include "codegen/reference_dynamics.h"
#include "codegen/reference_network.h"
#include "codegen/validate.h"

namespace nlo::codegen {

/// The observer's answers over one trajectory of N samples.
struct Run {
  Eigen::MatrixXd x_hat;  ///< n_x x N
  Eigen::MatrixXd z;      ///< n_z x N
  Eigen::MatrixXd y;      ///< n_y x N, the outputs as they were taken: held, clamped
};

template <class Scalar>
class ReferenceObserver {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the model. Throws Error unless it is valid (see validate.h).
  explicit ReferenceObserver(const Model& model) : ReferenceObserver(validated(model), Activations::kExact) {}

  /// The same, not validated, with the runtime's activations: for a model that is rewritten as it is exported.
  ReferenceObserver(const Model& model, Activations activations)
      : model_(model), dynamics_(reference_dynamics<Scalar>(model, activations)) {
    if (has_linear_latent(model)) steady_gain_ = codegen::steady_gain(model).cast<Scalar>();
    if (!model.luenberger) inverse_map_.emplace(model.inverse_map, activations);
    reset();
  }

  /// z = initial latent; the next sample is the first.
  void reset() {
    z_ = model_.initial_latent.cast<Scalar>();
    y_ = Eigen::VectorXd::Zero(model_.ny());
    u_ = Eigen::VectorXd::Zero(model_.nu());
    started_ = false;
    diverged_ = false;
  }

  /// One sample period with the outputs `y` (n_y) and, if driven, the inputs `u` (n_u). An entry that is not finite, or
  /// an angle out of its range, keeps its last good value; others are clamped to their range. Before the first sample
  /// that is good in all entries, nothing happens.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u = {}) { step(y, u, model_.sample_period_s); }

  /// The same over `dt_s` since the last sample. Structures that are integrated in pieces do nothing when that is more
  /// than kMostPieces sample periods.
  void step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s) {
    take(accepted(y, true), accepted_input(u), dt_s);
  }

  /// x_hat, n_x.
  Vector estimate() const { return inverse_map(z_, y_.cast<Scalar>()); }

  /// z, n_z. Angles are unwrapped from the first sample on, and z with them: subtract steady_gain() times the turns to
  /// compare with an observer that turns z back.
  const Vector& latent() const { return z_; }

  /// The outputs as the last step took them, n_y: held, clamped, angles unwrapped.
  const Eigen::VectorXd& output() const { return y_; }

  /// The last step would have left the finite numbers: z was kept.
  bool diverged() const { return diverged_; }

  /// A whole trajectory from reset: `outputs` n_y x N with angles unwrapped, `inputs` n_u x N (0 x 0 unless driven),
  /// `time_s` N. With `uniform` each step is the sample period, else it is the difference of the time stamps, where
  /// what is the sample period but for the stamps' rounding counts as it. Estimates are matrix products over blocks of
  /// samples. Throws Error when the inputs are not those of the model.
  Run run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s, bool uniform) {
    const Eigen::Index samples = outputs.cols();
    if (model_.nu() != inputs.rows() || (model_.nu() > 0 && inputs.cols() != samples))
      throw Error(
          fmt::format("\"{}\" has {} inputs over {} samples; it was given {} x {}: name the data's inputs as the "
                      "model does",
                      model_.name, model_.nu(), samples, inputs.rows(), inputs.cols()));
    Run run{Eigen::MatrixXd(model_.nx(), samples), Eigen::MatrixXd(model_.nz(), samples),
            Eigen::MatrixXd(model_.ny(), samples)};
    Matrix z(model_.nz(), samples), y(model_.ny(), samples);
    reset();
    for (Eigen::Index k = 0; k < samples; ++k) {
      const double since_last_s = uniform || k == 0 ? model_.sample_period_s : time_s(k) - time_s(k - 1);
      const bool nominal = std::abs(since_last_s - model_.sample_period_s) <= kSameStep * model_.sample_period_s;
      const double dt_s = nominal ? model_.sample_period_s : since_last_s;
      take(accepted(outputs.col(k), false), model_.drive ? accepted_input(inputs.col(k)) : u_, dt_s);
      z.col(k) = z_;
      y.col(k) = y_.cast<Scalar>();
      run.y.col(k) = y_;
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
  /// Relative. Stamps of 10^5 s in double have steps good to 1e-8 at 1 kHz; float's z cannot tell either.
  static constexpr double kSameStep = 1e-8;

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

  Eigen::VectorXd accepted_input(const Eigen::VectorXd& u) const {
    Eigen::VectorXd good = u;
    for (Eigen::Index i = 0; i < good.size(); ++i)
      if (!std::isfinite(good(i)) && started_) good(i) = u_(i);
    return good;
  }

  void take(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s) {
    if (!y.allFinite() || !u.allFinite()) return;  // before the first good sample
    diverged_ = false;
    next_y_ = y.cast<Scalar>();
    next_u_ = u.cast<Scalar>();
    if (!started_) {
      if (model_.starts_steady) z_ += steady_gain_ * next_y_;
    } else {
      const bool in_pieces = structure(model_) != "kkl";
      if (in_pieces && !(dt_s <= kMostPieces * model_.sample_period_s)) return;
      advance(dt_s);
    }
    y_ = y;
    u_ = u;
    last_y_ = next_y_;
    last_u_ = next_u_;
    started_ = true;
  }

  void advance(double dt_s) {
    candidate_ = z_;
    const Between<Scalar> between{last_y_, next_y_, last_u_, next_u_};
    std::visit([&](auto& dynamics) { dynamics.advance(model_, candidate_, between, dt_s); }, dynamics_);
    diverged_ = !(candidate_.allFinite() && candidate_.cwiseAbs().maxCoeff() <= Scalar(0x1p100));
    if (!diverged_) z_ = candidate_;
  }

  /// The inverse map as matrix products over blocks of samples.
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
    if (!inverse_map_) return z;
    if (model_.inverse_map.inputs() == z.rows()) return (*inverse_map_)(z);
    Matrix inputs(z.rows() + y.rows(), z.cols());
    inputs << z, y;
    return (*inverse_map_)(inputs);
  }

  Model model_;
  ReferenceDynamics<Scalar> dynamics_;
  Matrix steady_gain_;
  std::optional<ReferenceNetwork<Scalar>> inverse_map_;

  Vector z_;
  Eigen::VectorXd y_, u_;
  Vector candidate_, last_y_, next_y_, last_u_, next_u_;  // members, so that a step allocates little
  bool started_ = false, diverged_ = false;
};

// Compiled once, for speed, in reference_observer.cpp.
extern template class ReferenceObserver<float>;
extern template class ReferenceObserver<double>;

}  // namespace nlo::codegen
