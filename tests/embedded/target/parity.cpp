// SPDX-License-Identifier: MIT
// The deterministic policy gives the same bits everywhere: hashes of long runs must equal those of tests/golden with
// each compiler and core. The fast policy stays within its bound of the deterministic one.
#include <cstdint>
#include <limits>

#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "tests/embedded/target/text.h"

// Control of the tests: a build with fused arithmetic in place of the deterministic one must be detected.
#if !defined(NLO_PARITY_POLICY)
#define NLO_PARITY_POLICY kDeterministic
#endif

namespace nlo::target {
namespace {

constexpr int kSteps = 100'000;
constexpr int kGatedSteps = 10'000;  // a step costs as much as an estimate
constexpr int kEstimateEvery = 50;   // an estimate takes 80,000 instructions if floats are emulated

// Bound of |fast - deterministic| for estimates of order 1. A sum of n terms has at most n roundings of half a unit in
// the last place: 17 inputs x 3 layers x 6e-8 = 3e-6 if all add up.
constexpr float kFastBound = 3e-6F;

constexpr auto kPlain = bench::random_kkl_model<Activation::kTanh, 16, 2>();
constexpr auto kRelu = bench::random_kkl_model<Activation::kRelu, 13, 2>();
constexpr auto kAngle = [] {
  auto model = bench::random_kkl_model<Activation::kSilu, 9, 1>();
  model.outputs.wrap[0] = 6.2831855F;
  model.latent.starts_steady = true;
  return model;
}();

constexpr auto kGated = bench::random_gated_model<6>();

float normal_measurement(bench::RandomUniform& random, int k) {
  const float phase = static_cast<float>(k % 314) / 157.0F - 1.0F;
  const float wave = rounded(phase * (phase < 0 ? 1.0F + phase : 1.0F - phase));  // never fused
  return rounded(4.0F * wave) + rounded(0.3F * random());
}

/// A number from any 32 bits: half of all floats lie outside [1e-19, 1e19], and one in 256 is not finite.
float hostile_measurement(bench::RandomUniform& random) {
  random();
  return std::bit_cast<float>(random.state ^ random.state >> 16);
}

/// A step with one of the many faults that an observer may meet.
template <class Observer>
StepStatus hostile_step(Observer& observer, bench::RandomUniform& random, int k) {
  const float y = random() < 0 ? hostile_measurement(random) : normal_measurement(random, k);
  switch (random.state >> 28) {
    case 0:
      return observer.step(y, 0.02F * random());  // half of them negative: rejected
    case 1:
      return observer.step(y, std::bit_cast<float>(random.state));
    case 2:
      return observer.step(y, 15.0F);  // 750 sample periods
    case 3:
      return observer.step_missed();
    case 4:
      if constexpr (Observer::Model::kHasSteadyState) {
        if (k % 7 == 0) return observer.warm_start(y);
      }
      return observer.step(y);
    case 5:
      return observer.step(std::numeric_limits<float>::denorm_min());
    default:
      return observer.step(y);
  }
}

template <class Model>
bool run(const char* name, const Model& model, bool hostile, int steps = kSteps) {
  SampledObserver<Model, Arithmetic::NLO_PARITY_POLICY> observer{model};
  SampledObserver<Model> fast{model};
  bench::RandomUniform random{1};
  Hash hash;
  float worst = 0;
  for (int k = 0; k < steps; ++k) {
    const StepStatus status =
        hostile ? hostile_step(observer, random, k) : observer.step(normal_measurement(random, k));
    hash.add(static_cast<std::uint32_t>(status) + (observer.in_domain() ? 8U : 0U));
    for (const float z : observer.latent()) hash.add(z);
    if (k % kEstimateEvery != 0) continue;
    const auto x_hat = observer.estimate();
    for (const float x : x_hat) hash.add(x);
    // From the same latent state: far from the domain, estimates of two latent states that differ in one bit are far
    // apart.
    if (hostile || !fast.reset(observer.latent(), {{observer.save().y[0]}})) continue;
    const auto x_fast = fast.estimate();
    for (int i = 0; i < 2; ++i) {
      const float difference = x_hat[i] < x_fast[i] ? x_fast[i] - x_hat[i] : x_hat[i] - x_fast[i];
      if (!(difference <= worst)) worst = difference;
    }
  }
  board::write("deterministic ");
  board::write(name);
  board::write(hostile ? " hostile " : " normal ");
  hash.write();
  if (worst <= kFastBound) return true;
  board::write("fast arithmetic differs by more than its bound\n");
  return false;
}

}  // namespace

bool run_all() {
  bool good = true;
  for (const bool hostile : {false, true}) {
    good = run("tanh", kPlain, hostile) && good;
    good = run("relu", kRelu, hostile) && good;
    good = run("angle-silu", kAngle, hostile) && good;
    good = run("gated", kGated, hostile, kGatedSteps) && good;
  }
  return good;
}

}  // namespace nlo::target

int main() {
  return nlo::target::run_all() ? 0 : 1;
}
