// SPDX-License-Identifier: MIT
// Integrators of nonlinear parts: orders of convergence, and closed forms that the exponential scheme must reproduce.
#include <nlo/explicit_rk.h>
#include <nlo/exponential_rk.h>

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace nlo {
namespace {

/// Order of convergence: log2 of the factor by which the error falls if the step is halved.
double order(double coarse, double fine) {
  return std::log2(coarse / fine);
}

// Largest difference of a measured order from that of the method, at steps where the leading term dominates.
constexpr double kOrderTolerance = 0.15;

/// z1' = z2, z2' = -sin(z1) - 0.2 z2 + cos(t) from (1, 0) to t = 2.
template <int kStages>
void run_pendulum(const Tableau<double, kStages>& tableau, int steps, double (&z)[2]) {
  const double h = 2.0 / steps;
  z[0] = 1.0;
  z[1] = 0.0;
  for (int k = 0; k < steps; ++k) {
    explicit_rk_step(tableau, h, z, [&](double c, const double(&at)[2], double(&dz)[2]) {
      dz[0] = at[1];
      dz[1] = -std::sin(at[0]) - 0.2 * at[1] + std::cos((k + c) * h);
    });
  }
}

template <int kStages>
double measured_order(const Tableau<double, kStages>& tableau) {
  double exact[2], coarse[2], fine[2];
  run_pendulum(kRk4<double>, 4096, exact);
  run_pendulum(tableau, 64, coarse);
  run_pendulum(tableau, 128, fine);
  const auto error = [&](const double(&z)[2]) { return std::hypot(z[0] - exact[0], z[1] - exact[1]); };
  return order(error(coarse), error(fine));
}

TEST(ExplicitRk, ConvergesAtTheOrderOfItsTableau) {
  EXPECT_NEAR(measured_order(kEuler<double>), kEuler<double>.order, kOrderTolerance);
  EXPECT_NEAR(measured_order(kHeun<double>), kHeun<double>.order, kOrderTolerance);
  EXPECT_NEAR(measured_order(kRk4<double>), kRk4<double>.order, kOrderTolerance);
}

TEST(ExplicitRk, OrderDetectsAWrongCoefficient) {
  auto altered = kRk4<double>;
  altered.a[2][1] = 0.49;
  EXPECT_LT(measured_order(altered), 3.0);
}

TEST(ExplicitRk, DividesGapsIntoStepsOfAboutOneSamplePeriod) {
  EXPECT_EQ(pieces_of(0.001, 0.02), 1);
  EXPECT_EQ(pieces_of(0.02, 0.02), 1);
  EXPECT_EQ(pieces_of(0.0299, 0.02), 1);
  EXPECT_EQ(pieces_of(0.031, 0.02), 2);
  EXPECT_EQ(pieces_of(0.2, 0.02), 10);
  EXPECT_EQ(pieces_of(1e9, 0.02), kMostPieces);
  for (int k = 1; k < 6400; ++k) EXPECT_LE(0.0002 * k / pieces_of(0.0002 * k, 0.02), 0.02 * 1.5 * (1 + 1e-12)) << k;
}

using Cd = std::complex<double>;

TEST(ForcedPhi, AgreesWithItsClosedForms) {
  // (exp(w) - 1 - w - w^2 / 2) / w^3 loses 1 / |w|^3 roundings to cancellation; the functions themselves contribute 2
  // (1 + |w|).
  for (const Cd w : {Cd(-0.7, 0.0), Cd(-1.3, 2.0), Cd(-9.0, 0.0), Cd(-40.0, 30.0), Cd(-0.5, -0.5), Cd(-700.0, 0.0)}) {
    const auto p = ForcedPhi<double>::at({w.real(), w.imag()});
    const Cd phi1 = (std::exp(w) - 1.0) / w, phi2 = (phi1 - 1.0) / w, phi3 = (phi2 - 0.5) / w;
    const double size = std::abs(w);
    const double tolerance = 2.3e-16 * (20.0 / std::pow(size, 3) + 4.0 * (1.0 + size));
    EXPECT_LT(std::abs(Cd(p.exp_minus_1.re, p.exp_minus_1.im) - (std::exp(w) - 1.0)), tolerance) << w;
    EXPECT_LT(std::abs(Cd(p.phi1.re, p.phi1.im) - phi1), tolerance) << w;
    EXPECT_LT(std::abs(Cd(p.phi2.re, p.phi2.im) - phi2), tolerance) << w;
    EXPECT_LT(std::abs(Cd(p.phi3.re, p.phi3.im) - phi3), tolerance) << w;
  }
  const auto zero = ForcedPhi<double>::at({0.0, 0.0});
  EXPECT_EQ(zero.phi3.re, 1.0 / 6);
}

/// A pair and a real mode, one output.
struct Forced {
  double eigenvalues[3] = {-2.0, 3.0, -6.0};
  double injection[3][1] = {{2.0}, {-3.0}, {6.0}};

  /// z(2) from (1, 0, -1) with y = 0.3 t, a ramp for any step, and a slope N that couples all modes.
  ///   weight_factor  factor on one weight of the scheme
  void run(int steps, double (&z)[3], double weight_factor = 1.0) const {
    const double h = 2.0 / steps;
    const auto step = discretise<1>(Hold::kFirstOrder, eigenvalues, injection, h);
    auto forced = forced_step<1>(Hold::kFirstOrder, eigenvalues, injection, h);
    for (double& weight : forced.weights.stage3_2.values) weight *= weight_factor;
    z[0] = 1.0;
    z[1] = 0.0;
    z[2] = -1.0;
    for (int k = 0; k < steps; ++k) {
      const double y[1] = {0.3 * k * h}, middle[1] = {0.3 * (k + 0.5) * h}, next[1] = {0.3 * (k + 1) * h};
      exponential_rk_step<1>(step, forced, z, y, middle, next, [&](double c, const double(&at)[3], double(&n)[3]) {
        const double u = std::cos(3 * (k + c) * h);
        n[0] = u * std::sin(at[1] + at[2]);
        n[1] = at[0] * at[0] * u;
        n[2] = std::tanh(at[0] - at[1]) + u;
      });
    }
  }

  double error(int steps, double weight_factor = 1.0) const {
    double exact[3], z[3];
    run(2048, exact);
    run(steps, z, weight_factor);
    return std::hypot(z[0] - exact[0], std::hypot(z[1] - exact[1], z[2] - exact[2]));
  }
};

TEST(ExponentialRk, ConvergesAtOrderFour) {
  const Forced forced;
  EXPECT_NEAR(order(forced.error(64), forced.error(128)), 4.0, kOrderTolerance);
}

TEST(ExponentialRk, AgreesWithRungeKuttaForSmallSteps) {
  constexpr double kTolerance = 1e-9;  // both of order 4 with steps of 1 ms: (6e-3)^4 / 120 a second
  const Forced forced;
  double z[3], plain[3] = {1.0, 0.0, -1.0};
  forced.run(2000, z);
  const double h = 1e-3;
  for (int k = 0; k < 2000; ++k) {
    explicit_rk_step(kRk4<double>, h, plain, [&](double c, const double(&at)[3], double(&dz)[3]) {
      const double y = 0.3 * (k + c) * h, u = std::cos(3 * (k + c) * h);
      dz[0] = -2.0 * at[0] - 3.0 * at[1] + 2.0 * y + u * std::sin(at[1] + at[2]);
      dz[1] = 3.0 * at[0] - 2.0 * at[1] - 3.0 * y + at[0] * at[0] * u;
      dz[2] = -6.0 * at[2] + 6.0 * y + std::tanh(at[0] - at[1]) + u;
    });
  }
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(z[r], plain[r], kTolerance);
}

TEST(ExponentialRk, OrderDetectsAWrongWeight) {
  const Forced forced;
  constexpr double kWeightFactor = 1.005;
  EXPECT_LT(order(forced.error(64, kWeightFactor), forced.error(128, kWeightFactor)), 3.0);
}

TEST(ExponentialRk, ConstantForcingIsExactForAnyPole) {
  // z' = lambda z + n: z+ = z + (exp(lambda h) - 1) (z + n / lambda). An integrating factor would be wrong by 70 % at
  // lambda h = -10.
  constexpr double kTolerance = 1e-14;
  for (const double lambda : {-0.01, -1.0, -10.0, -200.0}) {
    const double eigenvalues[1] = {lambda}, injection[1][1] = {{0.0}}, y[1] = {0.0};
    double z[1] = {0.5};
    exponential_rk_step<0>(discretise<0>(Hold::kFirstOrder, eigenvalues, injection, 1.0),
                           forced_step<0>(Hold::kFirstOrder, eigenvalues, injection, 1.0), z, y, y, y,
                           [](double, const double(&)[1], double(&n)[1]) { n[0] = 3.0; });
    EXPECT_NEAR(z[0], 0.5 + std::expm1(lambda) * (0.5 + 3.0 / lambda), kTolerance * (1 + 3.0 / -lambda)) << lambda;
  }
}

TEST(ExponentialRk, WithoutForcingEqualsTheLinearRecurrence) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
    const Forced f;
    const auto step = discretise<1>(hold, f.eigenvalues, f.injection, 0.02);
    const auto forced = forced_step<1>(hold, f.eigenvalues, f.injection, 0.02);
    double z[3] = {1.0, 0.3, -1.0}, plain[3] = {1.0, 0.3, -1.0};
    for (int k = 0; k < 100; ++k) {
      const double y[1] = {std::sin(0.1 * k)}, next[1] = {std::sin(0.1 * (k + 1))}, middle[1] = {(y[0] + next[0]) / 2};
      exponential_rk_step<1>(step, forced, z, y, middle, next,
                             [](double, const double(&)[3], double(&n)[3]) { n[0] = n[1] = n[2] = 0.0; });
      advance<1>(step, plain, y, next);
      for (int r = 0; r < 3; ++r) ASSERT_EQ(z[r], plain[r]);
    }
  }
}

}  // namespace
}  // namespace nlo
