// SPDX-License-Identifier: MIT
// Losses of T in double precision: gradients agree with finite differences, values with closed forms.
#include "trainer/learn/losses/map_terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "trainer/learn/losses/loss_registry.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

constexpr int kColumns = 8;
using Losses = MapBlock<double, kColumns>;
constexpr int kStride = Losses::kStride;

struct Variant {
  const char* name;
  std::function<void(Experiment&)> change;
};

/// Each term alone and all together, for each latent system that may have T.
const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"map_consistency", [](Experiment& e) { e.loss.weights["map_consistency"] = 0.7; }},
      {"reconstruction", [](Experiment& e) { e.loss.weights["reconstruction"] = 1.3; }},
      {"pde_residual", [](Experiment& e) { e.loss.weights["pde_residual"] = 0.4; }},
      {"all_normalised",
       [](Experiment& e) {
         e.loss.weights["map_consistency"] = e.loss.weights["reconstruction"] = e.loss.weights["pde_residual"] = 0.5;
         e.loss.scale = ErrorScale::kNormalised;
       }},
      {"pde_residual_silu",
       [](Experiment& e) {
         e.loss.weights["pde_residual"] = 0.4;
         e.forward_map.activation = "silu";
       }},
      {"pde_residual_of_pairs_with_unit_gain",
       [](Experiment& e) {
         e.loss.weights["pde_residual"] = 0.4;
         e.observer.pairs = {{-0.5, 1.5}};
         e.observer.output_injection = Injection::kUnitGain;
       }},
      {"reconstruction_reading_the_output",
       [](Experiment& e) {
         e.loss.weights["reconstruction"] = 1.0;
         e.observer.features = FeatureSet::kLatentAndOutput;
       }},
  };
  return all;
}

struct Problem {
  Experiment experiment;
  ObserverStructure structure;
  std::vector<double> inverse, forward, eigenvalues;
  std::vector<double> x, z, y, f, h, weight;
  int count = 6;  // number of used columns; a block has 8

  explicit Problem(const Variant& variant) {
    experiment.observer.eigenvalues = {-1.2, -3.0};
    experiment.inverse_map.hidden = {4};
    experiment.forward_map.hidden = {5, 4};
    variant.change(experiment);
    structure = make_structure(experiment, needs_forward_map(experiment.loss), {{"y1", "", 0.0}, {"y2", "", 0.0}},
                               {{"x1", "", 0.0}, {"x2", "", 0.0}});
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-0.8, 0.8);
    const auto draw = [&](std::size_t size) {
      std::vector<double> values(size);
      for (double& value : values) value = uniform(random);
      return values;
    };
    for (float& mean : structure.state_mean) mean = static_cast<float>(uniform(random));
    for (float& scale : structure.state_scale) scale = static_cast<float>(1.5 + uniform(random));
    for (float& mean : structure.latent_mean) mean = static_cast<float>(uniform(random));
    for (float& scale : structure.latent_scale) scale = static_cast<float>(1.5 + uniform(random));
    for (Feature& feature : structure.features) feature.scale = static_cast<float>(1.5 + uniform(random));
    const auto nz = static_cast<std::size_t>(structure.latent.rows);
    inverse = draw(static_cast<std::size_t>(structure.network.parameters));
    forward = draw(static_cast<std::size_t>(structure.forward_map->parameters));
    eigenvalues = structure.eigenvalues;
    x = draw(2 * kStride);
    f = draw(2 * kStride);
    y = draw(2 * kStride);
    h = draw(2 * kStride);
    z = draw(nz * kStride);
    weight = draw(kStride);
    for (double& w : weight) w += 1.0;
  }

  MapSamples<double> samples() const {
    return {.count = count,
            .x = x.data(),
            .z = z.data(),
            .y = y.data(),
            .f = f.data(),
            .h = h.data(),
            .weight = weight.data()};
  }

  Losses block() const { return {structure, experiment.loss.is_normalised(), needs_equations(experiment.loss)}; }

  /// Evaluates all terms with a weight; if `z` is given, also their gradients.
  double run(Losses& losses, double* cotangent_z) const {
    const LossConfig& l = experiment.loss;
    const MapSamples<double> at = samples();
    double loss = 0.0;
    losses.forward(at);
    if (const double w = l.weight("map_consistency"); w > 0.0) loss += map_consistency(losses, at, w, cotangent_z);
    if (const double w = l.weight("reconstruction"); w > 0.0) loss += reconstruction(losses, at, w, cotangent_z);
    if (cotangent_z != nullptr) losses.backward(count);
    if (const double w = l.weight("pde_residual"); w > 0.0) loss += pde_residual(losses, at, w, cotangent_z != nullptr);
    return loss;
  }

  double loss() const {
    Losses losses = block();
    losses.prepare(inverse.data(), forward.data(), eigenvalues);
    return run(losses, nullptr);
  }
};

TEST(MapLosses, GradientsAgreeWithFiniteDifferencesForEveryTerm) {
  constexpr double kStep = 1e-5, kTolerance = 2e-9;  // rounding 1e-16 / 1e-5 and truncation 1e-10, of losses of some 50
  for (const Variant& variant : variants()) {
    SCOPED_TRACE(variant.name);
    Problem problem(variant);
    Losses losses = problem.block();
    losses.prepare(problem.inverse.data(), problem.forward.data(), problem.eigenvalues);
    losses.clear_gradient();
    std::vector<double> inverse(problem.inverse.size()), forward(problem.forward.size()),
        eigenvalues(problem.eigenvalues.size()), z(problem.z.size(), 0.0);
    const double loss = problem.run(losses, z.data());
    losses.gradient(inverse.data(), forward.data(), eigenvalues.data());
    EXPECT_NEAR(loss, problem.loss(), 1e-13 * (1.0 + loss));

    double largest = 0.0;
    const auto check = [&](const char* what, std::vector<double>& values, const std::vector<double>& gradient,
                           const std::function<bool(std::size_t)>& used) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double kept = values[i];
        values[i] = kept + kStep;
        const double up = problem.loss();
        values[i] = kept - kStep;
        const double down = problem.loss();
        values[i] = kept;
        const double difference = (up - down) / (2.0 * kStep);
        largest = std::max(largest, std::abs(difference));
        ASSERT_NEAR(used(i) ? gradient[i] : 0.0, difference, kTolerance * (1.0 + loss)) << what << " " << i;
      }
    };
    const auto all = [](std::size_t) { return true; };
    check("T*", problem.inverse, inverse, all);
    check("T", problem.forward, forward, all);
    check("eigenvalue", problem.eigenvalues, eigenvalues, all);
    check("z", problem.z, z, [&](std::size_t i) { return static_cast<int>(i) % kStride < problem.count; });
    EXPECT_GT(largest, 0.1) << "the tolerance would pass a gradient of zero";
  }
}

TEST(MapLosses, ResidualVanishesForTheSolutionOfALinearPlant) {
  // x' = -a x, y = x: T = c x with c (-a) = lambda c + 1, so c = -1 / (a + lambda). A network without hidden layers
  // holds it exactly.
  Experiment experiment;
  experiment.observer.eigenvalues = {-2.0};
  experiment.inverse_map.hidden = {};
  experiment.forward_map.hidden = {};
  experiment.loss.weights["pde_residual"] = 1.0;
  const ObserverStructure structure =
      make_structure(experiment, needs_forward_map(experiment.loss), {{"y", "", 0.0}}, {{"x", "", 0.0}});
  constexpr double kA = 0.5;
  std::vector<double> x(kStride), f(kStride), weight(kStride, 1.0);
  for (int s = 0; s < kStride; ++s) {
    x[static_cast<std::size_t>(s)] = 0.3 * s - 1.0;
    f[static_cast<std::size_t>(s)] = -kA * x[static_cast<std::size_t>(s)];
  }
  const MapSamples<double> samples{
      .count = kColumns, .x = x.data(), .f = f.data(), .h = x.data(), .weight = weight.data()};
  const std::vector<double> inverse = {1.0, 0.0};
  const auto residual_of = [&](double c) {
    const std::vector<double> forward = {c, 0.0};
    Losses losses(structure, false, true);
    losses.prepare(inverse.data(), forward.data(), structure.eigenvalues);
    return pde_residual(losses, samples, 1.0, false);
  };
  EXPECT_LT(residual_of(-1.0 / (kA - 2.0)), 1e-24);
  EXPECT_GT(residual_of(-1.1 / (kA - 2.0)), 1e-3);  // control
}

/// One state, one real eigenvalue, linear maps: T(x) = m_z + s_z (a u + b) with u = (x - m_x) / s_x, and
/// T*(z) = m_x + s_x (p (z - m_f) / s_f + q). Every loss is a formula of these numbers.
struct ClosedForm {
  static constexpr double kMx = 0.25, kSx = 2.0, kMz = -0.5, kSz = 4.0, kMf = 0.125, kSf = 0.5;
  static constexpr double kA = 0.75, kB = -0.3, kP = 1.5, kQ = 0.2, kLambda = -3.0;
  static constexpr double kMy = -0.4, kSy = 0.8, kPy = -0.65;  // mean and scale of the output for T*, and a value
  static constexpr double kX = 0.6, kZ = 1.1, kF = -0.7, kH = 0.9, kWeight = 1.75;

  Experiment experiment;
  ObserverStructure structure;
  std::vector<double> inverse = {kP, kQ};

  explicit ClosedForm(bool reads_output = false) {
    if (reads_output) experiment.observer.features = FeatureSet::kLatentAndOutput;
    experiment.observer.eigenvalues = {kLambda};
    experiment.inverse_map.hidden = experiment.forward_map.hidden = {};
    experiment.loss.weights["map_consistency"] = 1.0;  // so that there is a T
    structure = make_structure(experiment, needs_forward_map(experiment.loss), {{"y", "", 0.0}}, {{"x", "", 0.0}});
    structure.state_mean = {static_cast<float>(kMx)};
    structure.state_scale = {static_cast<float>(kSx)};
    structure.latent_mean = {static_cast<float>(kMz)};
    structure.latent_scale = {static_cast<float>(kSz)};
    structure.features.front().mean = static_cast<float>(kMf);
    structure.features.front().scale = static_cast<float>(kSf);
    if (!reads_output) return;
    structure.features.back().mean = static_cast<float>(kMy);
    structure.features.back().scale = static_cast<float>(kSy);
    inverse = {kP, kPy, kQ};
  }

  static double map() { return kMz + kSz * (kA * (kX - kMx) / kSx + kB); }

  template <class Value>
  double value(bool normalised, const Value& of) const {
    std::vector<double> x(kStride), z(kStride), f(kStride), h(kStride), weight(kStride);
    x[0] = kX, z[0] = kZ, f[0] = kF, h[0] = kH, weight[0] = kWeight;
    const MapSamples<double> samples{
        .count = 1, .x = x.data(), .z = z.data(), .y = h.data(), .f = f.data(), .h = h.data(), .weight = weight.data()};
    const std::vector<double> forward = {kA, kB};
    Losses losses(structure, normalised, true);
    losses.prepare(inverse.data(), forward.data(), {kLambda});
    losses.forward(samples);
    return of(losses, samples);
  }
};

constexpr double kRounding = 1e-13;
constexpr double kTermWeight = 0.6;
constexpr double kFloatScales = 1e-6;  // scales of features are floats, and 0.8 is not a float
double* const kNoCotangent = nullptr;

TEST(MapLosses, ConsistencyIsTheSquaredErrorOfT) {
  const double expected = kTermWeight * ClosedForm::kWeight * std::pow(ClosedForm::kZ - ClosedForm::map(), 2);
  const auto value = [](Losses& block, const MapSamples<double>& samples) {
    return map_consistency(block, samples, kTermWeight, kNoCotangent);
  };
  EXPECT_NEAR(ClosedForm().value(false, value), expected, kRounding);
  EXPECT_NEAR(ClosedForm().value(true, value), expected / std::pow(ClosedForm::kSz, 2), kRounding);
}

TEST(MapLosses, ReconstructionIsTheSquaredErrorOfTInverseAfterT) {
  using C = ClosedForm;
  const double back = C::kMx + C::kSx * (C::kP * (C::map() - C::kMf) / C::kSf + C::kQ);
  const double expected = kTermWeight * C::kWeight * std::pow(C::kX - back, 2);
  const auto value = [](Losses& block, const MapSamples<double>& samples) {
    return reconstruction(block, samples, kTermWeight, kNoCotangent);
  };
  EXPECT_NEAR(C().value(false, value), expected, kRounding * expected);
  EXPECT_NEAR(C().value(true, value), expected / std::pow(C::kSx, 2), kRounding * expected);
}

TEST(MapLosses, ReconstructionReadsTheMeasuredOutput) {
  using C = ClosedForm;
  const double read = C::kP * (C::map() - C::kMf) / C::kSf + C::kPy * (C::kH - C::kMy) / C::kSy;
  const double expected = kTermWeight * C::kWeight * std::pow(C::kX - C::kMx - C::kSx * (read + C::kQ), 2);
  const auto value = [](Losses& block, const MapSamples<double>& samples) {
    return reconstruction(block, samples, kTermWeight, kNoCotangent);
  };
  EXPECT_NEAR(C(true).value(false, value), expected, kFloatScales * expected);
}

TEST(MapLosses, ResidualIsTheSquaredDefectOfTheEquation) {
  using C = ClosedForm;
  const double slope = C::kSz * C::kA / C::kSx;
  const double defect = slope * C::kF - C::kLambda * C::map() - C::kH;
  const double expected = kTermWeight * C::kWeight * defect * defect;
  const auto value = [](Losses& block, const MapSamples<double>& samples) {
    return pde_residual(block, samples, kTermWeight, false);
  };
  EXPECT_NEAR(C().value(false, value), expected, kRounding * expected);
  EXPECT_NEAR(C().value(true, value), expected / std::pow(C::kSz, 2), kRounding * expected);
}

}  // namespace
}  // namespace nlo::trainer
