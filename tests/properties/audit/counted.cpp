// SPDX-License-Identifier: MIT
// A thousand samples of one kind through an observer with the deterministic policy, for instruction_count.sh.
//   usage: counted KIND     one of the kinds of measurements() below; prints the statuses of the samples
// -DANGLE: the measurement is an angle. Controls that must be detected: -DCONTROL=1, work for only some of the samples;
// -DCONTROL=2, the fast policy, which branches.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>

#include "bench/random_model.h"

namespace {

constexpr int kSamples = 1000;

constexpr auto model() {
  auto made = nlo::bench::random_kkl_model<nlo::Activation::NLO_ACTIVATION, 16, 2>();
#if defined(ANGLE)
  constexpr float kTurn = 6.2831853F;
  made.outputs.min[0] = -kTurn / 2.0F;
  made.outputs.max[0] = kTurn / 2.0F;
  made.outputs.wrap[0] = kTurn;
#endif
  return made;
}

constexpr auto kModel = model();
#if CONTROL == 2
constexpr auto kArithmetic = nlo::Arithmetic::kFast;
#else
constexpr auto kArithmetic = nlo::Arithmetic::kDeterministic;
#endif
constinit nlo::KklObserver<decltype(kModel), kArithmetic> observer{kModel};

/// Fills y with measurements for step() that are the same on every platform. Returns false for an unknown kind.
bool measurements(const char* kind, std::array<float, kSamples>& y) {
  using Limits = std::numeric_limits<float>;
  constexpr float kExtremes[] = {Limits::max(),     -Limits::max(), Limits::min(), -Limits::min(), 10.0F, -10.0F,
                                 Limits::epsilon(), 10.000001F,     -10.000001F,   1e30F,          -0.0F, 3.1415927F};
  nlo::bench::RandomUniform random{7};
  for (std::size_t k = 0; k < y.size(); ++k) {
    const float uniform = random();
    if (std::strcmp(kind, "zeros") == 0) {
      y[k] = 0.0F;
    } else if (std::strcmp(kind, "random") == 0) {
      y[k] = 3.0F * uniform;
    } else if (std::strcmp(kind, "subnormal") == 0) {
      y[k] = uniform * Limits::min();
    } else if (std::strcmp(kind, "nan") == 0) {
      y[k] = Limits::quiet_NaN();
    } else if (std::strcmp(kind, "infinite") == 0) {
      y[k] = uniform < 0.0F ? -Limits::infinity() : Limits::infinity();
    } else if (std::strcmp(kind, "extreme") == 0) {
      y[k] = kExtremes[k % std::size(kExtremes)];
    } else if (std::strcmp(kind, "turning") == 0) {  // an angle that makes full turns
      y[k] = 0.01F * static_cast<float>(static_cast<int>(k * 97 % 628) - 314);
    } else if (std::strcmp(kind, "mixed") == 0) {
      y[k] = k % 7 == 0 ? Limits::quiet_NaN() : k % 5 == 0 ? 1e30F * uniform : 3.0F * uniform;
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace

/// Only the instructions of this function are counted.
extern "C" __attribute__((noinline)) void counted(const float* y, unsigned* statuses, float* x_hat) {
  for (int k = 0; k < kSamples; ++k) {
    const nlo::StepStatus status = observer.step(y[k]);
    ++statuses[static_cast<unsigned>(status)];
    const auto estimate = observer.estimate();
    x_hat[0] = estimate[0];
    x_hat[1] = estimate[1];
    statuses[8] += observer.in_domain() ? 1U : 0U;
#if CONTROL == 1
    for (volatile int i = 0; status == nlo::StepStatus::kClamped && i < 5;) i = i + 1;
#endif
  }
}

int main(int argc, char** argv) {
  std::array<float, kSamples> y{};
  if (argc != 2 || !measurements(argv[1], y)) {
    std::fputs("usage: counted zeros|random|subnormal|nan|infinite|extreme|turning|mixed\n", stderr);
    return 2;
  }
  static_cast<void>(observer.step(0.5F));  // the first measurement only starts the observer
  unsigned statuses[9] = {};
  float x_hat[2] = {};
  counted(y.data(), statuses, x_hat);
  std::printf("ok %u, clamped %u, held %u, stale %u, out of range %u, in domain %u; x_hat %g %g\n", statuses[0],
              statuses[1], statuses[2], statuses[3], statuses[4], statuses[8], static_cast<double>(x_hat[0]),
              static_cast<double>(x_hat[1]));
  return 0;
}
