// SPDX-License-Identifier: MIT
// Gated units in integers: the emulation of the exporter equals the runtime bit for bit, and both agree with the
// equations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/random_quantised_model.h"
#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/replay/reference_observer.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/unpacked_layer.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;

template <int kUnits, int kNy>
void expect_same_bits() {
  constexpr auto kModel = bench::random_quantised_gated_model<kUnits, 1, kNy>();
  QuantisedUnits units;
  units.gates.layers = {unpacked(kModel.gates.mlp.layer)};
  units.candidate.layers = {unpacked(kModel.candidate.mlp.layer)};
  units.gates.centre = Eigen::VectorXf::Zero(kNy);
  units.gates.gain = Eigen::VectorXf::Constant(kNy, kModel.gates.gain[0]);

  bench::RandomUniform uniform{5};
  Eigen::VectorXf emulated = Eigen::VectorXf::Zero(kUnits);
  for (int k = 0; k < 3000; ++k) {
    if (k % 500 == 400)  // restart from any state, also from states that no step reaches
      for (float& z : emulated) z = (k % 1000 == 400 ? 1.0F : 1e6F) * uniform();
    float z[kUnits], y[kNy];
    std::copy(emulated.begin(), emulated.end(), z);
    for (float& value : y) value = (k % 10 == 0 ? 1e4F : 12.0F) * uniform();
    const bool regular = k % 3 != 0;
    const float dt_s = regular ? 0.0F : 0.1F * (1.0F + uniform());
    emulated = stepped(units, emulated, Eigen::Map<const Eigen::VectorXf>(y, kNy), regular, dt_s / 0.02F);
    kModel.advance(z, y, y, dt_s);
    for (int r = 0; r < kUnits; ++r) {
      ASSERT_EQ(z[r], emulated(r)) << "step " << k << ", unit " << r;
      ASSERT_LT(std::abs(z[r]), 1.0F);
      ASSERT_EQ(z[r] * 0x1p23F, std::round(z[r] * 0x1p23F));
    }
  }
}

TEST(QuantisedUnits, EmulationHasTheBitsOfTheRuntime) {
  expect_same_bits<16, 1>();
  expect_same_bits<7, 2>();
  expect_same_bits<32, 3>();
}

TEST(QuantisedUnits, KeepsABitFlipDetectable) {
  constexpr auto kModel = bench::random_quantised_gated_model<16>();
  SampledObserver<std::remove_const_t<decltype(kModel)>> observer{kModel};
  ASSERT_EQ(observer.step(0.5F), StepStatus::kOk);
  const auto before = observer.save();
  for (const float corrupted :
       {std::numeric_limits<float>::quiet_NaN(), 1e38F, -std::numeric_limits<float>::infinity()}) {
    float z[16];
    std::copy(std::begin(before.z), std::end(before.z), z);
    z[3] = corrupted;
    const float y[1] = {0.5F};
    kModel.advance(z, y, y, 0.0F);
    EXPECT_FALSE(is_reachable(z)) << corrupted;
  }
}

/// Returns the largest difference of z between integers and the equations in double, for readings that change slowly
/// and fast.
double largest_error(const Model& m) {
  const FoldedModel folded = fold(m);
  const QuantisedModel quantised = quantise(m, folded);
  ReferenceObserver<double> exact(m);
  ReferenceObserver<float> integer(m, Activations::kRuntime, flown_ranges(m), &quantised);
  double largest = 0.0;
  for (int k = 0; k < 3000; ++k) {
    Eigen::VectorXd y(m.ny());
    for (int j = 0; j < m.ny(); ++j) {
      const double middle = (m.output_max(j) + m.output_min(j)) / 2.0, half = (m.output_max(j) - m.output_min(j)) / 2.0;
      const double value = middle + 0.9 * half * std::sin(0.01 * (j + 1) * k + 1e-5 * k * k);
      y(j) = static_cast<double>(static_cast<float>(value));
    }
    const double dt_s = k % 7 == 0 ? 1.5 * m.sample_period_s : m.sample_period_s;
    exact.step(y, {}, dt_s);
    integer.step(y, {}, dt_s);
    largest = std::max(largest, (exact.latent() - integer.latent().cast<double>()).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(QuantisedUnits, StayWithinTheirBound) {
  for (const Model& m : {gated_model(), contracting_gated_model()}) EXPECT_LT(largest_error(m), 1e-3) << m.name;
}

TEST(QuantisedUnits, RefusesHugeWeightsAndNamesTheirLayer) {
  Model m = gated_model();
  networks(m)[1].network->layers[0].weights(1, 0) = 1e9;
  EXPECT_THAT(thrown_message([&] { quantise(m, fold(m)); }), HasSubstr("candidate.layers[0]: neuron 1 has sums up to"));
}

}  // namespace
}  // namespace nlo::codegen
