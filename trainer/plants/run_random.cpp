// SPDX-License-Identifier: MIT
// Compiled with -ffp-contract=off (CMakeLists.txt): a fused multiplication would round differently.
#include "trainer/plants/run_random.h"

#include <algorithm>
#include <cmath>

#include "trainer/base/engine_draws.h"
#include "trainer/base/random.h"

namespace nlo::trainer {

double sine_of_turns(double t) {
  // t = (q + f) / 4 with an integer q and |f| <= 1/2. Then |angle| <= pi / 4, and the next term of the series is below
  // 1e-17.
  constexpr double kHalfPi = 1.5707963267948966;
  const double part = t - std::floor(t), q = std::floor(4.0 * part + 0.5), angle = (4.0 * part - q) * kHalfPi;
  const double s = angle * angle;
  const int quarter = static_cast<int>(q) % 4;
  double sum = 1.0;
  if (quarter % 2 == 0) {
    for (int n = 16; n >= 2; n -= 2) sum = 1.0 - s / static_cast<double>(n * (n + 1)) * sum;
    sum *= angle;
  } else {
    for (int n = 17; n >= 1; n -= 2) sum = 1.0 - s / static_cast<double>(n * (n + 1)) * sum;
  }
  return quarter < 2 ? sum : -sum;
}

double portable_log(double x) {
  // x = m 2^e with m in [sqrt 1/2, sqrt 2): ln m = 2 artanh s, s = (m - 1) / (m + 1), |s| < 0.172.
  constexpr double kLn2 = 0.6931471805599453, kRootHalf = 0.7071067811865476;
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < kRootHalf) {
    m *= 2.0;
    --e;
  }
  const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
  double sum = 0.0;
  for (int n = 23; n >= 1; n -= 2) sum = 1.0 / static_cast<double>(n) + s2 * sum;
  return static_cast<double>(e) * kLn2 + 2.0 * s * sum;
}

double portable_exp(double x) {
  // x = k ln 2 + r, |r| <= ln 2 / 2, by ln 2 in two parts: k times the first is exact.
  constexpr double kLn2High = 0x1.62e42fefa38p-1, kLn2Low = 0x1.ef35793c7673p-45;
  const double k = std::floor(x / 0.6931471805599453 + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  double sum = 1.0;
  for (int n = 15; n >= 1; --n) sum = 1.0 + r / static_cast<double>(n) * sum;
  return std::ldexp(sum, static_cast<int>(k));
}

RunRandom::RunRandom(std::uint64_t engine_seed, RunPurpose purpose, std::uint64_t part, std::uint64_t run)
    : engine_(stream_seed(~engine_seed, static_cast<Purpose>(purpose), part, run)) {}

double RunRandom::uniform() {
  return uniform01(engine_);
}

double RunRandom::between(double low, double high) {
  const double u = uniform();
  return std::min((1.0 - u) * low + u * high, high);
}

double RunRandom::log_between(double low, double high) {
  const double u = uniform();
  return std::clamp(low * portable_exp(u * portable_log(high / low)), low, high);
}

double RunRandom::normal() {
  return normal_pair(engine_, portable_log).first;
}

std::size_t RunRandom::index(std::size_t count) {
  return std::min(static_cast<std::size_t>(uniform() * static_cast<double>(count)), count - 1);
}

}  // namespace nlo::trainer
