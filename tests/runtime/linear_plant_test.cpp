// SPDX-License-Identifier: MIT
// A linear plant has a known solution: T solves T A = D T + F C, its pseudo-inverse is a one-layer T*, and the
// estimation error must fall like exp(max Re(lambda) t), down to rounding.
#include <nlo/eigen.h>
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using Matrix = Eigen::MatrixXd;

constexpr double kSlowest = -1.0;  // max Re(lambda)

/// vec(T) from P T - T Q = R, with T n_z x n_x.
Matrix solve_sylvester(const Matrix& p, const Matrix& q, const Matrix& r) {
  const Eigen::Index nz = p.rows(), nx = q.rows();
  Matrix system = Matrix::Zero(nz * nx, nz * nx);
  for (Eigen::Index j = 0; j < nx; ++j) {
    system.block(j * nz, j * nz, nz, nz) += p;
    for (Eigen::Index i = 0; i < nx; ++i) system.block(j * nz, i * nz, nz, nz) -= q(i, j) * Matrix::Identity(nz, nz);
  }
  const Eigen::VectorXd solution = testing::solve(system, Eigen::Map<const Matrix>(r.data(), nz * nx, 1));
  return Eigen::Map<const Matrix>(solution.data(), nz, nx);
}

template <class Scalar>
using Model = KklModel<Scalar, 2, 1, 3, 1, LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 3, 2>>>>;

/// x1' = x2, x2' = -x1, y = x1, with a pair at -2 +- 1.5i and a real mode at -1.
template <class Scalar>
struct Oscillator {
  Matrix a = (Matrix(2, 2) << 0, 1, -1, 0).finished(), c = (Matrix(1, 2) << 1, 0).finished();
  Matrix d = (Matrix(3, 3) << -2, -1.5, 0, 1.5, -2, 0, 0, 0, kSlowest).finished();
  Matrix f = (Matrix(3, 1) << 1, 0.5, 2).finished();
  Matrix t;
  Model<Scalar> model{};

  /// `sampled`: T of the plant sampled with linear interpolation, T Phi = A T + B0 C + B1 C Phi, instead of the
  /// continuous T.
  Oscillator(double h, bool sampled) {
    model.sample_period_s = static_cast<Scalar>(h);
    model.stale_after = 5;
    model.latent.hold = Hold::kFirstOrder;
    model.latent.eigenvalues[0] = Scalar(-2);
    model.latent.eigenvalues[1] = Scalar(1.5);
    model.latent.eigenvalues[2] = Scalar(kSlowest);
    for (int r = 0; r < 3; ++r) model.latent.output_injection[r][0] = static_cast<Scalar>(f(r));
    model.outputs.min[0] = Scalar(-10);
    model.outputs.max[0] = Scalar(10);
    testing::complete(model);
    t = solve_sylvester(d, a, -f * c);
    if (sampled) {
      const Matrix flow = testing::exponential(a * h);
      Matrix b0(3, 1), b1(3, 1), az = Matrix::Zero(3, 3);
      const auto& step = model.latent.step;
      for (int r = 0; r < 3; ++r) {
        b0(r) = static_cast<double>(step.b0[r][0]);
        b1(r) = static_cast<double>(step.b1[r][0]);
        az(r, r) = 1.0 + static_cast<double>(step.a_minus_1[r == 1 ? 0 : r]);
      }
      az(1, 0) = static_cast<double>(step.a_minus_1[1]);
      az(0, 1) = -az(1, 0);
      t = solve_sylvester(az, flow, -(b0 * c + b1 * c * flow));
    }
    const Matrix inverse = testing::pseudo_inverse(t);
    Dense<Scalar, 3, 2> layer{};
    for (int o = 0; o < 2; ++o) {
      for (int i = 0; i < 3; ++i) layer.weights[o][i] = static_cast<Scalar>(inverse(o, i));
    }
    model.inverse_map.mlp = make_mlp<Activation::kTanh>(layer);
  }
};

/// |x - x_hat| at t = k h, k = 0.. steps, from x = (1.5, -0.5) and z = 0.
template <class Scalar>
std::vector<double> errors(const Model<Scalar>& model, double h, int steps) {
  KklObserver<Model<Scalar>> observer(model);
  std::vector<double> result;
  for (int k = 0; k <= steps; ++k) {
    const double c = std::cos(k * h), s = std::sin(k * h);
    const Eigen::Vector2d x(1.5 * c - 0.5 * s, -1.5 * s - 0.5 * c);
    EXPECT_EQ(observer.step(static_cast<Scalar>(x(0))), StepStatus::kOk);
    const auto x_hat = observer.estimate();
    result.push_back((as_eigen(x_hat).template cast<double>() - x).norm());
  }
  return result;
}

/// |m| of two rows: the root of the larger eigenvalue of m m^T.
double norm_of_two_rows(const Matrix& m) {
  const Eigen::Matrix2d g = m * m.transpose();
  return std::sqrt((g(0, 0) + g(1, 1)) / 2 + std::hypot((g(0, 0) - g(1, 1)) / 2, g(0, 1)));
}

double largest(const std::vector<double>& values, double h, double from_s, double to_s) {
  const auto at = [&](double t) { return values.begin() + static_cast<std::ptrdiff_t>(std::lround(t / h)); };
  return *std::max_element(at(from_s), at(to_s) + 1);
}

TEST(LinearPlant, ErrorFallsAtTheRateOfTheSlowestEigenvalue) {
  constexpr double h = 1e-3;
  // Linear interpolation of a sine: h^2 / 12 = 8e-8, compared with an error of 1e-4 at 9 s.
  constexpr double kRampError = 2e-3;
  const Oscillator<double> plant(h, false);
  const auto error = errors(plant.model, h, 12000);
  const double rate = std::log(error[9000] / error[6000]) / 3.0;
  EXPECT_NEAR(rate, kSlowest, kRampError + 5e-3);  // the faster pair has decayed to exp(-6) at 6 s
  // |T* (z - T x)| <= |T*| |T x0| exp(max Re(lambda) t): D is normal.
  const Matrix inverse = testing::pseudo_inverse(plant.t);
  const double start = (plant.t * Eigen::Vector2d(1.5, -0.5)).norm() * norm_of_two_rows(inverse);
  for (int k = 0; k <= 10000; ++k) {
    ASSERT_LE(error[static_cast<std::size_t>(k)], start * std::exp(kSlowest * k * h) + 1e-6) << k;
  }
}

TEST(LinearPlant, ErrorSettlesAtRounding) {
  constexpr double h = 0.02;
  // Each step rounds |z| ~ 2 by about half a unit and forgets 1 - exp(-0.02) of the accumulated error: at worst 50
  // steps, times |T*| ~ 10; the T of the sampled plant is then exact. A continuous T would leave h^2 / 12 = 3e-5.
  const auto settled = [](double eps) { return 2 * 50 * 10 * eps / 2; };
  const Oscillator<double> plant(h, true);
  const auto error = errors(plant.model, h, 3000);
  EXPECT_LT(largest(error, h, 45.0, 60.0), settled(std::numeric_limits<double>::epsilon()));
  const Oscillator<float> narrow(h, true);
  const auto narrow_error = errors(narrow.model, h, 3000);
  EXPECT_LT(largest(narrow_error, h, 25.0, 60.0), settled(static_cast<double>(std::numeric_limits<float>::epsilon())));
  EXPECT_GT(narrow_error[0], 0.1);  // control: the initial error is not small
}

TEST(LinearPlant, ErrorDetectsAWrongCoefficient) {
  Oscillator<double> plant(0.02, true);
  std::swap(plant.model.latent.step.b0, plant.model.latent.step.b1);
  const auto error = errors(plant.model, 0.02, 3000);
  EXPECT_GT(largest(error, 0.02, 45.0, 60.0), 1e-6);
}

TEST(EigenViews, ShareTheVectorsMemory) {
  Vector<float, 3> v{{1.0F, 2.0F, 3.0F}};
  as_eigen(v)(1) = 7.0F;
  EXPECT_EQ(v[1], 7.0F);
  const Vector<float, 3> copy = from_eigen(2.0F * as_eigen(v));
  EXPECT_EQ(copy[1], 14.0F);
  EXPECT_EQ(as_eigen(copy).data(), copy.data());
}

}  // namespace
}  // namespace nlo
