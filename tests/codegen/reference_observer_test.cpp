// SPDX-License-Identifier: MIT
#include "codegen/replay/reference_observer.h"
#include "codegen/model/latent_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/fold/fold.h"
#include "codegen/reference/reference_network.h"
#include "codegen/structures/structure_module.h"
#include "tests/codegen/example_models.h"

namespace nlo::codegen {
namespace {

/// Smooth outputs within the declared range. Angles may leave it, because they are unwrapped.
Eigen::MatrixXd smooth_outputs(const Model& m, const Eigen::VectorXd& time_s) {
  Eigen::MatrixXd y(m.ny(), time_s.size());
  for (int j = 0; j < m.ny(); ++j) {
    const double centre = (m.output_min(j) + m.output_max(j)) / 2, half = (m.output_max(j) - m.output_min(j)) / 2;
    y.row(j) = centre + 0.6 * half * ((3.0 + j) * time_s.array()).sin() + 0.3 * half * (7.3 * time_s.array() + j).cos();
  }
  return y;
}

Eigen::VectorXd times(const Model& m, Eigen::Index samples) {
  return Eigen::VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) * m.sample_period_s);
}

/// Inputs of a driven model within +-1; empty for other models.
Eigen::MatrixXd smooth_inputs(const Model& m, const Eigen::VectorXd& time_s) {
  Eigen::MatrixXd u(m.nu(), m.nu() > 0 ? time_s.size() : 0);
  for (int i = 0; i < m.nu(); ++i) u.row(i) = (2.3 * time_s.array() + i).sin();
  return u;
}

/// D as a matrix.
Eigen::MatrixXd latent_matrix(const Model& m) {
  return block_diagonal(m, linear_latent(m)->eigenvalues);
}

TEST(ReferenceObserver, LatentSolvesTheDifferentialEquationBetweenRamps) {
  constexpr int kSubsteps = 64;        // classical Runge-Kutta inside each sample:
  constexpr double kTolerance = 1e-9;  // (60/s * 4 ms / 64)^4 / 120 of |z| ~ 5 per time constant is 1e-12
  for (const Model& m : {paper_model(), rig_model()}) {
    const Eigen::VectorXd t = times(m, 200);
    const Eigen::MatrixXd y = smooth_outputs(m, t);
    const auto run = ReferenceObserver<double>(m).run(y, {}, t, true);
    const Eigen::MatrixXd d = latent_matrix(m);
    Eigen::VectorXd z = run.z.col(0);
    for (Eigen::Index k = 0; k + 1 < t.size(); ++k) {
      const double h = (t(k + 1) - t(k)) / kSubsteps;
      for (int i = 0; i < kSubsteps; ++i) {
        const auto slope = [&](const Eigen::VectorXd& at, double part) -> Eigen::VectorXd {
          const double s = (i + part) / kSubsteps;
          return d * at + linear_latent(m)->output_injection * ((1 - s) * y.col(k) + s * y.col(k + 1));
        };
        const Eigen::VectorXd k1 = slope(z, 0), k2 = slope(z + h / 2 * k1, 0.5), k3 = slope(z + h / 2 * k2, 0.5),
                              k4 = slope(z + h * k3, 1);
        z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      }
      ASSERT_LT((z - run.z.col(k + 1)).cwiseAbs().maxCoeff(), kTolerance) << m.name << " at sample " << k + 1;
    }
  }
}

/// Returns z after 1 s of ramps in y and u (ramps for any sample period), with `steps` samples.
Eigen::VectorXd after_a_second(Model m, int steps) {
  m.sample_period_s = 1.0 / steps;
  const Eigen::RowVectorXd t = Eigen::RowVectorXd::LinSpaced(steps + 1, 0.0, 1.0);
  Eigen::MatrixXd y(m.ny(), steps + 1), u(m.nu(), m.nu() > 0 ? steps + 1 : 0);
  for (int j = 0; j < m.ny(); ++j) y.row(j) = ((j + 1.0) * t).array() - 0.5;
  for (int i = 0; i < m.nu(); ++i) u.row(i) = 1.0 - (i + 1.0) * t.array();
  return ReferenceObserver<double>(m).run(y, u, t.transpose(), true).z.rightCols<1>();
}

TEST(ReferenceObserver, ConvergesAtOrderFourForNonlinearStructures) {
  constexpr double kOrderTolerance = 0.3;  // the time scales of the networks are not far above steps of 1/32 s
  for (const Model& m : structure_models()) {
    if (m.name == "gated" || m.name == "carried" || m.name == "prior") continue;  // tested below; prior has gated units
    const Eigen::VectorXd exact = after_a_second(m, 2048);
    const double coarse = (after_a_second(m, 32) - exact).norm(), fine = (after_a_second(m, 64) - exact).norm();
    EXPECT_NEAR(std::log2(coarse / fine), 4.0, kOrderTolerance) << m.name << ": " << coarse << " to " << fine;
  }
}

TEST(ReferenceObserver, GatedUnitsConvergeAtOrderOneToTheirDifferentialEquation) {
  // A step holds rates and targets constant, so halving it halves the error. Reference: RK4 of the differential
  // equation with steps of 1/4096 s.
  const Model m = gated_model();
  const Eigen::Vector2d y(0.8, -0.4);
  const auto after_a_second = [&](int steps) -> Eigen::VectorXd {
    ReferenceObserver<double> observer(m);
    observer.step(y);
    for (int k = 0; k < steps; ++k) observer.step(y, {}, 1.0 / steps);
    return observer.latent();
  };
  ReferenceObserver<double> observer(m);
  observer.step(y);
  Eigen::MatrixXd z = observer.latent();
  const auto dynamics = module_of(m).dynamics_in_double(m, Activations::kExact);
  const auto slope = [&](const Eigen::MatrixXd& at) { return dynamics->slope(at, y, {}); };
  constexpr double kStep = 1.0 / 4096.0;
  for (int k = 0; k < 4096; ++k) {
    const Eigen::MatrixXd k1 = slope(z), k2 = slope(z + kStep / 2 * k1), k3 = slope(z + kStep / 2 * k2),
                          k4 = slope(z + kStep * k3);
    z += kStep / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  const double coarse = (after_a_second(1024) - z).norm(), fine = (after_a_second(2048) - z).norm();
  EXPECT_GT(coarse, 1e-6) << "control: coarse steps differ from the solution";
  EXPECT_NEAR(std::log2(coarse / fine), 1.0, 0.1) << coarse << " to " << fine;
}

TEST(ReferenceObserver, AFilterIsThePriorWhoseCorrectionsAreZero) {
  const Model filter = filter_functions_model();
  Model prior = prior_functions_model();
  Network& correction = std::get<Prior>(prior.structure).correction;
  correction.layers[0].weights.setZero();
  correction.layers[0].bias.setZero();
  correction.output_mean.setZero();
  ReferenceObserver<double> without(filter), with(prior);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector2d y(std::sin(0.1 * k), std::cos(0.13 * k));
    const Eigen::VectorXd u = Eigen::VectorXd::Constant(1, 0.5 * std::sin(0.07 * k));
    without.step(y, u);
    with.step(y, u);
    ASSERT_LT((without.latent() - with.latent().tail(5)).cwiseAbs().maxCoeff(), 1e-13)
        << "rounding alone, sample " << k;
  }
}

TEST(ReferenceObserver, GatedStepEqualsItsDocumentedEquation) {
  // z+ = z + (1 - (1 + exp(2 a_s))^-n) (target - z) over n sample periods: softplus written as a power, for arguments
  // that do not overflow.
  const Model m = gated_model();
  const Gated& own = own_part<Gated>(m);
  const ReferenceNetwork<double> gates(own.gates), candidate(own.candidate);
  const Eigen::Vector2d y(0.8, -0.4);
  for (const double periods : {1.0, 0.3, 7.0}) {
    ReferenceObserver<double> observer(m);
    observer.step(y);
    const Eigen::VectorXd z = observer.latent();
    Eigen::VectorXd read(m.nz() + 2);
    read << z, y;
    const Eigen::VectorXd a = gates(read);
    Eigen::VectorXd candidate_reads = read;
    candidate_reads.head(m.nz()).array() *= (1.0 + a.tail(m.nz()).array().tanh()) / 2.0;
    const Eigen::VectorXd target = Eigen::VectorXd(candidate(candidate_reads)).array().tanh();
    const Eigen::VectorXd share = 1.0 - (1.0 + (2.0 * a.head(m.nz()).array()).exp()).pow(-periods);
    observer.step(y, {}, periods * m.sample_period_s);
    EXPECT_LT((observer.latent() - (z + share.cwiseProduct(target - z))).norm(), 1e-12) << periods;
    EXPECT_GT(share.maxCoeff() - share.minCoeff(), 0.01) << "control: units differ";
  }
}

TEST(ReferenceObserver, CarriedVectorsConvergeToTheirDifferentialEquation) {
  // Between samples the observer takes y as a ramp in axes fixed in the world. The equation takes y as a ramp in the
  // axes of the body. The difference is of second order.
  const Model m = carried_model();
  const auto y = [&](double t) {
    Eigen::VectorXd readings(9);
    for (int j = 0; j < 6; ++j) readings(j) = (j + 1.0) * t - 0.5;
    for (int i = 0; i < 3; ++i) readings(6 + i) = 1.0 - (i + 1.0) * t;
    return readings;
  };
  ReferenceObserver<double> observer(m);
  observer.step(y(0.0).head(6), y(0.0).tail(3));
  Eigen::MatrixXd z = observer.latent();
  const auto dynamics = module_of(m).dynamics_in_double(m, Activations::kExact);
  constexpr int kSteps = 1024;
  constexpr double h = 1.0 / kSteps;
  for (int k = 0; k < kSteps; ++k) {
    const auto slope = [&](const Eigen::MatrixXd& at, double part) {
      return dynamics->slope(at, y((k + part) * h), {});
    };
    const Eigen::MatrixXd k1 = slope(z, 0), k2 = slope(z + h / 2 * k1, 0.5), k3 = slope(z + h / 2 * k2, 0.5),
                          k4 = slope(z + h * k3, 1);
    z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  const double coarse = (after_a_second(m, 64) - z).norm(), fine = (after_a_second(m, 128) - z).norm();
  EXPECT_GT(coarse, 1e-6) << "control: coarse steps differ from the solution";
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1) << coarse << " to " << fine;
}

TEST(ReferenceObserver, ABatchEqualsSingleSteps) {
  constexpr double kTolerance = 1e-12;  // matrix products of other sizes add in another order
  for (const Model& m : example_models()) {
    Eigen::VectorXd t = times(m, 700);  // more than one block
    t += 0.3 * m.sample_period_s * (t.array() * 91.0 / m.sample_period_s).sin().matrix();
    // Within +-pi, so that angles need no unwrapping.
    const Eigen::MatrixXd y = smooth_outputs(m, t).array().min(3.0).max(-3.0);
    const Eigen::MatrixXd u = smooth_inputs(m, t);
    ReferenceObserver<double> observer(m);
    const auto run = observer.run(y, u, t, false);
    observer.reset();
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const Eigen::VectorXd input = m.nu() > 0 ? Eigen::VectorXd(u.col(k)) : Eigen::VectorXd();
      observer.step(y.col(k), input, k == 0 ? m.sample_period_s : t(k) - t(k - 1));
      ASSERT_LT((observer.latent() - run.z.col(k)).cwiseAbs().maxCoeff(), kTolerance) << m.name;
      ASSERT_LT((observer.estimate() - run.x_hat.col(k)).cwiseAbs().maxCoeff(), kTolerance) << m.name;
    }
  }
}

TEST(ReferenceObserver, GivesTheEstimateOfTheEdgeBeyondItsSaturation) {
  for (const Model& m : {saturating_model(), saturating_rig_model()}) {
    Model free = m;
    free.saturation = 0.0;
    const LatentReach reach(m);
    const LatentDomain domain(m);
    const Eigen::VectorXd y = 0.5 * (reading_min(m) + reading_max(m)).array() + 0.1;
    const Eigen::VectorXd rest = domain.relative_gain() * y, half = 0.5 * (reach.max - reach.min);
    const Eigen::VectorXd middle = rest + 0.5 * (reach.max + reach.min);
    const ReferenceObserver<double> observer(m), unlimited(free);
    for (int r = 0; r < m.nz(); ++r) {
      for (const double side : {-1.0, 1.0}) {
        Eigen::VectorXd inside = middle, edge = middle, beyond = middle;
        inside(r) += 0.999 * side * half(r);
        edge(r) += side * half(r);
        beyond(r) += 7.0 * side * half(r);
        EXPECT_EQ(observer.estimates(inside, y), unlimited.estimates(inside, y)) << m.name;
        EXPECT_LT((observer.estimates(beyond, y) - unlimited.estimates(edge, y)).norm(), 1e-12) << m.name;  // rounding
        EXPECT_GT((unlimited.estimates(beyond, y) - unlimited.estimates(edge, y)).norm(), 1e-6)
            << m.name << ": control";
      }
    }
  }
}

TEST(ReferenceObserver, FloatFollowsDouble) {
  // About a hundred roundings of 6e-8, times gains of weights and state scales up to 20.
  constexpr double kTolerance = 2e-4;
  for (const Model& m : example_models()) {
    const Eigen::VectorXd t = times(m, 600);
    const Eigen::MatrixXd y = smooth_outputs(m, t);
    const Eigen::MatrixXd u = smooth_inputs(m, t);
    const auto single = ReferenceObserver<float>(m).run(y, u, t, true);
    const auto twice = ReferenceObserver<double>(m).run(y, u, t, true);
    EXPECT_LT((single.x_hat - twice.x_hat).cwiseAbs().maxCoeff(), kTolerance) << m.name;
  }
}

TEST(ReferenceObserver, StaysInTheSteadyStateOfAConstantOutput) {
  const Model m = rig_model();
  ReferenceObserver<double> observer(m);
  const Eigen::Vector2d y(1.3, -2.0);
  observer.step(y);
  const Eigen::VectorXd z0 = observer.latent();
  for (int k = 0; k < 1000; ++k) observer.step(y);
  EXPECT_LT((observer.latent() - z0).head(6).cwiseAbs().maxCoeff(), 1e-12);  // all except the clock
  EXPECT_LT((z0 - m.initial_latent - steady_gain(m) * y).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(ReferenceNetwork, MultipliesFeaturesByTheirClocks) {
  Network n;
  n.features = (Eigen::Matrix2d() << 2.0, 0.0, 0.0, 1.0).finished();
  n.features.conservativeResize(3, Eigen::NoChange);
  n.features.row(2) = n.features.row(0);
  n.feature_mean = Eigen::Vector3d(1.0, 0.0, 1.0);
  n.feature_scale = Eigen::Vector3d(4.0, 1.0, 4.0);
  n.feature_clocks = {-1, -1, 1};
  n.layers = {{Eigen::RowVector3d(1.0, 10.0, 100.0), Eigen::VectorXd::Constant(1, 0.5)}};
  n.output_mean = Eigen::VectorXd::Zero(1);
  n.output_scale = Eigen::VectorXd::Ones(1);
  // u = [(2 z - 1) / 4; c; (2 z - 1) / 4 c] = [1.25; 0.2; 0.25] at z = 3, c = 0.2
  EXPECT_NEAR(ReferenceNetwork<double>(n)(Eigen::Vector2d(3.0, 0.2))(0), 0.5 + 1.25 + 2.0 + 25.0, 1e-12);
}

TEST(ReferenceNetwork, EqualsItsFoldedFormWithProductsOfClocks) {
  constexpr double kTolerance = 1e-10;  // sums of 100 terms of order 10, in double
  for (const Model& m : {clocked_model(), clocked_rig_model(), fallback_model()}) {
    const Network& map = *inverse_map(m);
    const FoldedNetwork folded = *fold(m).inverse_map();
    EXPECT_EQ(folded.inputs(), m.nz() + m.nr()) << m.name;
    EXPECT_GT(folded.products.size(), 4U) << m.name;
    Eigen::MatrixXd in = Eigen::MatrixXd::Random(m.nz() + m.nr(), 50);
    const Eigen::MatrixXd expected = ReferenceNetwork<double>(map)(in),
                          got = ReferenceNetwork<double>(unfolded(folded, folded.inputs()))(in);
    EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), kTolerance) << m.name;
  }
}

TEST(ReferenceNetwork, FallsBackToItsRowIfTheirDistanceIsLarge) {
  Network n;
  n.features = Eigen::MatrixXd::Ones(1, 1);
  n.feature_mean = Eigen::VectorXd::Constant(1, 1.0);
  n.feature_scale = Eigen::VectorXd::Constant(1, 2.0);
  n.layers = {{Eigen::MatrixXd::Constant(2, 1, 10.0), Eigen::VectorXd::Zero(2)}};
  n.output_mean = Eigen::VectorXd::Zero(2);
  n.output_scale = Eigen::VectorXd::Ones(2);
  n.fallback = {
      {1}, Eigen::MatrixXd::Constant(1, 1, 6.0), Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Constant(1, 3.0)};
  // u = (in - 1) / 2, out = 10 u, row = 1 + 6 u. At u = 1 they are one reach apart, so half of the distance remains.
  const Eigen::MatrixXd out = ReferenceNetwork<double>(n)(Eigen::RowVector3d(1.5, 3.0, 1e12));
  EXPECT_EQ(out.row(0), Eigen::RowVector3d(2.5, 10.0, 5e12 - 5.0)) << "output 0 has no fallback";
  EXPECT_EQ(out(1, 0), 2.5) << "the network meets the row there";
  EXPECT_EQ(out(1, 1), 8.5);
  EXPECT_NEAR(out(1, 2) / (1.0 + 6.0 * (0.5e12 - 0.5)), 1.0, 1e-11);
}

TEST(ReferenceNetwork, DerivativeOfProductsAgreesWithCentralDifferences) {
  constexpr double kStep = 1e-5, kTolerance = 1e-7;  // error of order step^2, and rounding over the step
  for (const Model& m : {clocked_model(), clocked_rig_model()}) {
    const ReferenceNetwork<double> map(*inverse_map(m));
    const Eigen::Index n = m.nz() + m.nr();
    const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(n, -0.7, 0.9);
    const Eigen::MatrixXd slopes = map.jvp(at, Eigen::MatrixXd::Identity(n, n));
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, i);
      const Eigen::VectorXd expected = (map(at + step) - map(at - step)) / (2.0 * kStep);
      EXPECT_LT((slopes.col(i) - expected).cwiseAbs().maxCoeff(), kTolerance * (1.0 + expected.norm()))
          << m.name << " " << i;
    }
  }
}

TEST(ReferenceObserver, AFullTurnOfAnAngleHasNoEffect) {
  const Model m = rig_model();
  constexpr double kTurn = 6.283185307179586;
  constexpr double kTolerance = 1e-11;  // rounding of z, larger by about 6 per turn, times feature and state scales
  const Eigen::VectorXd t = times(m, 400);
  Eigen::MatrixXd y = smooth_outputs(m, t);
  const auto here = ReferenceObserver<double>(m).run(y, {}, t, true);
  y.row(0).array() += kTurn;
  const auto turned = ReferenceObserver<double>(m).run(y, {}, t, true);
  EXPECT_LT((here.x_hat - turned.x_hat).cwiseAbs().maxCoeff(), kTolerance);
  EXPECT_GT((here.z - turned.z).cwiseAbs().maxCoeff(), 1.0);
}

TEST(ReferenceObserver, UnwrapsAnglesThatPassTheEndOfTheirRange) {
  const Model m = rig_model();
  ReferenceObserver<double> observer(m);
  for (int k = 0; k < 2000; ++k) {
    const double angle = 0.01 * k;  // three turns
    observer.step(Eigen::Vector2d(std::remainder(angle, 2 * std::acos(-1.0)), 0.5));
    ASSERT_NEAR(observer.output()(0), angle, 1e-9);
  }
}

TEST(ReferenceObserver, HoldsTheLastGoodOutputAndClampsToTheRange) {
  const Model m = tiny_model();
  ReferenceObserver<double> faulty(m), mended(m);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  faulty.step(Eigen::VectorXd::Constant(1, nan));  // no value to hold: the observer still waits for the first one
  EXPECT_EQ(faulty.latent(), m.initial_latent);
  const double arriving[] = {0.5, 0.7, nan, inf, 9.0, -0.2}, meant[] = {0.5, 0.7, 0.7, 0.7, 3.0, -0.2};
  for (int k = 0; k < 6; ++k) {
    faulty.step(Eigen::VectorXd::Constant(1, arriving[k]));
    mended.step(Eigen::VectorXd::Constant(1, meant[k]));
  }
  EXPECT_EQ(faulty.latent(), mended.latent());
  EXPECT_EQ(faulty.estimate(), mended.estimate());
}

TEST(ReferenceObserver, RefusesInputsOfAnotherModel) {
  const Eigen::VectorXd t = times(driven_model(), 5);
  const Eigen::MatrixXd y = Eigen::MatrixXd::Zero(1, 5);
  EXPECT_THROW(ReferenceObserver<double>(driven_model()).run(y, {}, t, true), Error);
  EXPECT_THROW(ReferenceObserver<double>(driven_model()).run(y, Eigen::MatrixXd::Zero(2, 4), t, true), Error);
  EXPECT_THROW(ReferenceObserver<double>(tiny_model()).run(y, Eigen::MatrixXd::Zero(1, 5), t, true), Error);
  EXPECT_NO_THROW(ReferenceObserver<double>(driven_model()).run(y, Eigen::MatrixXd::Zero(2, 5), t, true));
}

TEST(ReferenceObserver, RefusesAnInvalidModel) {
  Model m = tiny_model();
  linear_latent(m)->eigenvalues(0) = 0.1;
  EXPECT_THROW(ReferenceObserver<double>{m}, Error);
}

}  // namespace
}  // namespace nlo::codegen
