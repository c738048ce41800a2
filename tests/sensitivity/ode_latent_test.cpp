// SPDX-License-Identifier: MIT
// Latent systems given by differential equations, for each structure of the registry: gradients agree with finite
// differences and with each other.
#include "trainer/gradients/sensitivity/ode_latent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "trainer/structures/observer_gain.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

constexpr double kHorizonS = 1.5;

struct StructureCase {
  std::string name;
  Experiment experiment;
};

Experiment kkl(Injection injection, std::vector<double> eigenvalues, std::vector<std::array<double, 2>> pairs) {
  Experiment e;
  e.observer.eigenvalues = std::move(eigenvalues);
  e.observer.pairs = std::move(pairs);
  e.observer.output_injection = injection;
  return e;
}

std::vector<StructureCase> structures() {
  std::vector<StructureCase> cases = {{"kkl_real", kkl(Injection::kOnes, {-0.7, -3.0}, {})},
                                      {"kkl_pair_unit_gain", kkl(Injection::kUnitGain, {-1.0}, {{-0.5, 2.0}})}};
  for (const char* activation : {"tanh", "silu"}) {
    Experiment general = kkl(Injection::kOnes, {-1.0}, {{-0.5, 2.0}});
    general.observer.structure = "general";
    general.dynamics = {{5, 4}, activation};
    cases.push_back({std::string("general_") + activation, general});
    Experiment luenberger;
    luenberger.observer.structure = "luenberger";
    luenberger.observer.own.set<LuenbergerConfig>() = {.state_matrix = {{0.0, 1.0}, {-1.0, 0.0}},
                                                       .output_matrix = {{1.0, 0.0}, {0.5, 1.0}},
                                                       .gain = {{2.0, 0.3}, {1.0, 1.5}}};
    luenberger.dynamics = {{6}, activation};
    cases.push_back({std::string("luenberger_") + activation, luenberger});
  }
  return cases;
}

/// One structure in double: two outputs, eight trajectories, and a random linear functional of z as the loss.
struct Problem {
  ObserverStructure structure;
  std::unique_ptr<OdeDynamics<double>> dynamics;
  std::vector<double> theta, outputs, latent, cotangent, steps_s;
  OdeRun<double> run;

  Problem(const Experiment& experiment, int length, Hold hold, bool jittered) {
    structure =
        make_structure(experiment, false, {{"y1", "", 0.0}, {"y2", "", 0.0}}, {{"x1", "", 0.0}, {"x2", "", 0.0}});
    dynamics = structure.module->lanes_in_double(structure);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    const std::vector<float> initial = initial_dynamics(structure, experiment);
    theta.assign(initial.begin(), initial.end());
    for (double& p : theta) p += uniform(random);
    const double h = kHorizonS / (length - 1);
    steps_s.assign(jittered ? static_cast<std::size_t>(length) * kGroup : 1, h);
    if (jittered)
      for (double& step : steps_s) step *= 1.0 + uniform(random);
    const auto size = [&](int rows) {
      return static_cast<std::size_t>(rows) * static_cast<std::size_t>(length) * kGroup;
    };
    outputs.resize(size(2));
    latent.resize(size(dynamics->rows()));
    cotangent.resize(latent.size());
    // Smooth signals that do not depend on the step, so that orders of convergence can be measured.
    for (int k = 0; k < length; ++k) {
      const double t = h * k;
      for (int l = 0; l < kGroup; ++l) {
        for (int j = 0; j < 2; ++j) outputs[at(j, k, length, l)] = 0.4 * (j + 1) + (0.3 * l - 0.8 * j) * t;
        for (int r = 0; r < dynamics->rows(); ++r) cotangent[at(r, k, length, l)] = h * std::cos((1.0 + r) * t + l);
      }
    }
    run = {.length = length,
           .hold = hold,
           .readings = outputs.data(),
           .steps_s = steps_s.data(),
           .uniform = !jittered,
           .latent = latent.data(),
           .cotangent = cotangent.data()};
  }
  Problem(const Problem&) = delete;

  static std::size_t at(int row, int k, int length, int lane) {
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(length) + static_cast<std::size_t>(k)) * kGroup +
           static_cast<std::size_t>(lane);
  }

  double loss(const RungeKutta& method, const std::vector<double>& parameters) {
    dynamics->prepare(parameters.data());
    integrate(*dynamics, method, run);
    double sum = 0.0;
    for (std::size_t i = 0; i < latent.size(); ++i) sum += latent[i] * cotangent[i];
    return sum;
  }

  template <class Pull>
  std::vector<double> gradient(const RungeKutta& method, const Pull& pull) {
    loss(method, theta);
    dynamics->clear_gradient();
    pull();
    std::vector<double> out(theta.size());
    dynamics->gradient(out.data());
    return out;
  }
  std::vector<double> by_backprop(const RungeKutta& method = kRk4<double>) {
    return gradient(method, [&] { backprop(*dynamics, method, run); });
  }
  std::vector<double> by_adjoint() {
    return gradient(kRk4<double>, [&] { adjoint(*dynamics, run); });
  }
};

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}
double largest(const std::vector<double>& a) {
  return largest_difference(a, std::vector<double>(a.size(), 0.0));
}

TEST(OdeLatent, BackpropAgreesWithDifferencesForEveryStructureMethodAndHold) {
  // Central differences at 1e-5: rounding 1e-16 / 1e-5, truncation 1e-10 of the third derivative.
  constexpr double kStep = 1e-5, kTolerance = 1e-8;
  struct Method {
    const char* name;
    RungeKutta steps;
  };
  for (const StructureCase& structure : structures()) {
    for (const Method& method : {Method{"euler", kEuler<double>}, {"heun", kHeun<double>}, {"rk4", kRk4<double>}}) {
      for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
        for (const bool jittered : {false, true}) {
          SCOPED_TRACE(structure.name + " " + method.name + (jittered ? " jittered" : ""));
          Problem problem(structure.experiment, 12, hold, jittered);
          const std::vector<double> gradient = problem.by_backprop(method.steps);
          const double scale = largest(gradient);
          for (std::size_t i = 0; i < gradient.size(); ++i) {
            std::vector<double> up = problem.theta, down = problem.theta;
            up[i] += kStep;
            down[i] -= kStep;
            const double difference =
                (problem.loss(method.steps, up) - problem.loss(method.steps, down)) / (2.0 * kStep);
            ASSERT_NEAR(gradient[i], difference, kTolerance * scale) << "parameter " << i;
          }
        }
      }
    }
  }
}

TEST(OdeLatent, AdjointApproachesBackpropAtFourthOrderForEveryStructure) {
  for (const StructureCase& structure : structures()) {
    SCOPED_TRACE(structure.name);
    std::vector<double> errors;
    for (const int length : {16, 31, 61}) {
      Problem problem(structure.experiment, length, Hold::kFirstOrder, false);
      const std::vector<double> exact = problem.by_backprop();
      errors.push_back(largest_difference(exact, problem.by_adjoint()) / largest(exact));
    }
    EXPECT_GT(errors[0], 1e-12) << "the error is below rounding at this step";
    for (std::size_t i = 0; i + 1 < errors.size(); ++i) {
      const double order = std::log2(errors[i] / errors[i + 1]);
      EXPECT_GT(order, 3.6) << errors[i] << " to " << errors[i + 1];
    }
  }
}

TEST(OdeLatent, AdjointAgreesWithBackpropForJitteredSteps) {
  for (const StructureCase& structure : structures()) {
    SCOPED_TRACE(structure.name);
    Problem problem(structure.experiment, 61, Hold::kFirstOrder, true);
    const std::vector<double> exact = problem.by_backprop();
    EXPECT_LT(largest_difference(exact, problem.by_adjoint()), 1e-5 * largest(exact));  // h^4 = 4e-7 times a constant
  }
}

TEST(OdeLatent, RollOutsConvergeAtTheOrderOfTheirMethod) {
  struct Method {
    RungeKutta steps;
    double order;
  };
  for (const StructureCase& structure : structures()) {
    for (const Method& method : {Method{kEuler<double>, 1.0}, {kHeun<double>, 2.0}, {kRk4<double>, 4.0}}) {
      SCOPED_TRACE(structure.name + " of order " + std::to_string(method.order));
      const auto end = [&](int length, const RungeKutta& steps) {
        Problem problem(structure.experiment, length, Hold::kFirstOrder,
                        false);  // y is a ramp, for which the hold is exact
        problem.loss(steps, problem.theta);
        std::vector<double> z;
        for (int r = 0; r < problem.dynamics->rows(); ++r)
          z.push_back(problem.latent[Problem::at(r, length - 1, length, 3)]);
        return z;
      };
      const std::vector<double> exact = end(2401, kRk4<double>);
      const double coarse = largest_difference(end(31, method.steps), exact);
      const double fine = largest_difference(end(61, method.steps), exact);
      EXPECT_NEAR(std::log2(coarse / fine), method.order, 0.4) << coarse << " to " << fine;
    }
  }
}

TEST(OdeLatent, LuenbergerEstimateConvergesWhenTheNonlinearityIsKnown) {
  // g_hat = 0 for a linear plant: the error decays only by A - G C, here like exp(-t).
  Experiment experiment;
  experiment.observer.structure = "luenberger";
  experiment.observer.own.set<LuenbergerConfig>() = {
      .state_matrix = {{0.0, 1.0}, {-1.0, 0.0}}, .output_matrix = {{1.0, 0.0}}, .gain_poles = {-1.0, -2.0}};
  experiment.dynamics.hidden = {3};
  const ObserverStructure structure =
      make_structure(experiment, false, {{"y", "", 0.0}}, {{"x1", "", 0.0}, {"x2", "", 0.0}});
  const auto dynamics = structure.module->lanes_in_double(structure);
  const std::vector<double> theta(static_cast<std::size_t>(dynamics->parameters()), 0.0);
  dynamics->prepare(theta.data());
  constexpr int kLength = 1001;
  const double h = 0.01;
  std::vector<double> outputs(kLength * kGroup), latent(2 * outputs.size());
  for (int k = 0; k < kLength; ++k) std::fill_n(outputs.data() + k * kGroup, kGroup, std::cos(h * k));
  integrate(*dynamics, kRk4<double>,
            OdeRun<double>{.length = kLength, .readings = outputs.data(), .steps_s = &h, .latent = latent.data()});
  const auto error = [&](int k) {
    const auto at = static_cast<std::size_t>(k) * kGroup;
    return std::hypot(latent[at] - std::cos(h * k), latent[outputs.size() + at] + std::sin(h * k));
  };
  // The linear interpolation between samples errs by h^2 / 12 of y: 1e-5.
  EXPECT_LT(error(kLength - 1), 2e-4);
  EXPECT_NEAR(error(500) / error(400), std::exp(-1.0), 0.05);
}

}  // namespace
}  // namespace nlo::trainer
