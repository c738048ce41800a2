// SPDX-License-Identifier: MIT
#include "codegen/validate_dynamics.h"

#include <nlo/latent.h>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <string>

#include "codegen/checks.h"
#include "codegen/latent_step.h"

namespace nlo::codegen {
namespace {

// Rounding in features * [S; I] is a few units in the last place of its largest term; a feature that really reads an
// angle is off by a fraction of one.
constexpr double kTurnTolerance = 1e-9;

// |lambda h| beyond which a latent state is a copy of the output: e^-1000 is zero in any precision.
constexpr double kFastest = 1000.0;

// Gaps are stepped in pieces of at most this many sample periods (nlo/explicit_rk.h).
constexpr double kLongestStep = 1.5;

/// A, the factor that an eigenvalue puts on its part of z in one sample, as float32 sees it.
std::complex<float> step_factor(std::complex<double> lambda, double h, const std::string& hold) {
  const auto mode =
      discretise(hold == "rk4" ? Hold::kRk4 : Hold::kFirstOrder, Complex<double>{lambda.real(), lambda.imag()}, h);
  return {static_cast<float>(1.0 + mode.a_minus_1.re), static_cast<float>(mode.a_minus_1.im)};
}

std::string text(std::complex<double> value) {
  if (value.imag() == 0.0) return fmt::format("{:.4g}", value.real());
  return fmt::format("{:.4g} {} {:.4g}i", value.real(), value.imag() < 0.0 ? '-' : '+', std::abs(value.imag()));
}

}  // namespace

void check_linear_latent(const Model& m) {
  const int nz = m.nz();
  if (m.pairs < 0 || 2 * m.pairs > nz)
    fail("pairs is {}; with {} latent states it must be 0 to {}", m.pairs, nz, nz / 2);
  check_shape(m.eigenvalues, nz, "eigenvalues", "n_z, the size of initial_latent");
  check_shape(m.output_injection, nz, m.ny(), "output_injection", "n_z x n_y");

  for (Eigen::Index i = 0; i < nz; ++i) {
    const bool paired = i < 2 * m.pairs;
    const std::complex<double> lambda(m.eigenvalues(i), paired ? m.eigenvalues(i + 1) : 0.0);
    if (!(lambda.real() < 0.0))
      fail("eigenvalues[{}] is {}; its real part must be negative (D must be Hurwitz), or z never forgets its start", i,
           lambda.real());
    if (!(std::abs(lambda) * m.sample_period_s < kFastest))
      fail("eigenvalues[{}] is {}; at the sample period of {} s that is beyond {} per sample: use a slower one", i,
           lambda.real(), m.sample_period_s, kFastest);
    const double radius = std::abs(std::complex<double>(step_factor(lambda, m.sample_period_s, m.hold)));
    if (!(radius < 1.0))
      fail("eigenvalues[{}] is {} and makes |A| = {} at the sample period of {} s (rounded to float); {}", i,
           lambda.real(), radius, m.sample_period_s,
           m.hold == "rk4" ? "rk4 is unstable here: use hold first_order, or a shorter sample period"
                           : "it is too slow to be told from an integrator: use a faster eigenvalue");
    if (paired) ++i;
  }
}

void check_turns(const Model& m) {
  const Eigen::MatrixXd gain = steady_gain(m);
  const Eigen::MatrixXd& features = m.inverse_map.features;
  for (int j = 0; j < m.ny(); ++j) {
    if (m.outputs[static_cast<std::size_t>(j)].wrap == 0.0) continue;
    Eigen::VectorXd turn = Eigen::VectorXd::Zero(m.nz() + m.ny());
    turn.head(m.nz()) = gain.col(j);
    turn(m.nz() + j) = 1.0;
    const Eigen::VectorXd seen = features * turn;
    // Against the largest entry of S, not each row's own: the quadrature part of a unit-gain pair is a rounded zero.
    const Eigen::VectorXd largest = features.rowwise().lpNorm<1>() * turn.lpNorm<Eigen::Infinity>();
    for (Eigen::Index i = 0; i < seen.size(); ++i)
      if (std::abs(seen(i)) > kTurnTolerance * largest(i))
        fail(
            "inverse_map.features[{}] changes by {} per unit of the angle outputs[{}] (\"{}\"); T* may read an angle "
            "only as z - S y (S = -D^-1 F), or as sine and cosine",
            i, seen(i), j, m.outputs[static_cast<std::size_t>(j)].name);
  }
}

void check_drive(const Model& m) {
  const Drive& drive = *m.drive;
  check_channels(drive.inputs, "drive.inputs");
  for (std::size_t i = 0; i < drive.inputs.size(); ++i)
    if (drive.inputs[i].wrap != 0.0)
      fail("drive.inputs[{}].wrap is {}; an input is taken as it comes: write 0", i, drive.inputs[i].wrap);
  if (drive.input_hold != "zero_order" && drive.input_hold != "first_order")
    fail("drive.input_hold is unknown; use zero_order (a command that has acted since the last sample) or first_order");
  const Eigen::Index entries = Eigen::Index{m.nx()} * m.nu();
  check_shape(drive.input_field.weights, entries, m.nx(), "drive.input_field.weights", "n_x n_u x n_x");
  check_shape(drive.input_field.bias, entries, "drive.input_field.bias", "n_x n_u");
  check_network(drive.forward_map, m.nx(), m.nz(), "drive.forward_map", "n_u x n_x");
}

void check_luenberger(const Model& m) {
  const LuenbergerDynamics& l = *m.luenberger;
  const int nx = m.nx();
  if (m.nz() != nx)
    fail(
        "initial_latent has {} entries; it must have {} (n_x: the latent state of a luenberger observer is its "
        "estimate)",
        m.nz(), nx);
  check_shape(l.state_matrix, nx, nx, "luenberger.state_matrix", "n_x x n_x");
  check_shape(l.output_matrix, m.ny(), nx, "luenberger.output_matrix", "n_y x n_x");
  check_shape(l.gain, nx, m.ny(), "luenberger.gain", "n_x x n_y");
  check_network(l.nonlinearity, nx, nx, "luenberger.nonlinearity", "n_u x n_x");

  const Eigen::VectorXcd eigenvalues = (l.state_matrix - l.gain * l.output_matrix).eigenvalues();
  for (const std::complex<double> lambda : eigenvalues) {
    if (!(lambda.real() < 0.0))
      fail(
          "luenberger.gain leaves A - G C with the eigenvalue {}; its real part must be negative (A - G C must be "
          "Hurwitz): choose a gain that makes it so",
          text(lambda));
    const double h = kLongestStep * m.sample_period_s;
    const auto mode = discretise(Hold::kRk4, Complex<double>{lambda.real(), lambda.imag()}, h);
    const double radius = std::abs(std::complex<double>(1.0 + mode.a_minus_1.re, mode.a_minus_1.im));
    if (!(radius < 1.0))
      fail(
          "luenberger.gain gives A - G C the eigenvalue {}, too fast for a Runge-Kutta step of {:.4g} s (|R| = {:.3g}; "
          "1.5 sample periods, which jitter may take): use a smaller gain, or a shorter sample period",
          text(lambda), h, radius);
  }
}

}  // namespace nlo::codegen
