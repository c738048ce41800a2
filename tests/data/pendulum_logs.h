// SPDX-License-Identifier: MIT
// Logs of a simulated pendulum in the format of a rig: it is thrown so that it turns over a few times and then swings.
// 60 Hz with stamps rounded to a millisecond, an encoder with a wrap and noise, a logged rate that lags, and a gap in
// two of the logs. The files in tests/data/pendulum/ are these texts; tests and documents use them without the logs of
// a real rig. After a change, NLO_REFRESH_GOLDENS=1 writes them again.
//   angle'' = -(g / l) sin angle - c angle',   l = 0.4 m, c = 0.3 1/s, hanging at 0
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>

namespace nlo::trainer {

struct PendulumLog {
  const char* file;
  unsigned seed;
  double angle, rate;        ///< initial state of the throw [rad, rad/s]
  double clock_s;            ///< the first time stamp
  double gap_from_s, gap_s;  ///< lost samples; none if gap_s is 0
};

inline constexpr std::array<PendulumLog, 4> kPendulumLogs = {{{"train_1.csv", 1, 0.3, 17.0, 2.347, 0.0, 0.0},
                                                              {"train_2.csv", 2, -1.2, -13.0, 0.0, 5.1, 0.4},
                                                              {"train_3.csv", 3, 2.6, 4.0, 71.905, 0.0, 0.0},
                                                              {"test.csv", 4, -0.4, 15.0, 12.001, 6.3, 0.5}}};

inline constexpr double kPendulumRate_hz = 60.0, kPendulumDuration_s = 18.0;
inline constexpr double kPendulumNoise_rad = 0.005;

/// Gaussian numbers with the same bits on every platform: sums of twelve uniform draws, without distributions of the
/// standard library.
inline double pendulum_noise(std::mt19937& engine) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(engine()) * 0x1p-32;
  return sum;
}

inline std::string pendulum_csv(const PendulumLog& log) {
  constexpr int kSubsteps = 20;  // RK4 at 0.8 ms: exact to the printed digits
  constexpr double kGravityOverLength = 9.81 / 0.4, kDamping = 0.3;
  const double period = 1.0 / kPendulumRate_hz, h = period / kSubsteps;
  const auto slope = [&](double angle, double rate) {
    return std::array<double, 2>{rate, -kGravityOverLength * std::sin(angle) - kDamping * rate};
  };
  std::mt19937 engine(log.seed);
  double angle = log.angle, rate = log.rate, logged_rate = 0.0, last = 0.0;
  std::string text = "time,angle,rate\n";
  const int samples = static_cast<int>(kPendulumDuration_s * kPendulumRate_hz);
  for (int k = 0; k < samples; ++k) {
    const double t = k * period, measured = angle + kPendulumNoise_rad * pendulum_noise(engine);
    // The logged rate is computed as in firmware: a low-passed difference, about four samples late.
    logged_rate = k == 0 ? 0.0 : 0.8 * logged_rate + 0.2 * (measured - last) / period;
    last = measured;
    if (log.gap_s == 0.0 || t < log.gap_from_s || t >= log.gap_from_s + log.gap_s) {
      char row[80];
      std::snprintf(row, sizeof row, "%.3f,%.4f,%.3f\n", log.clock_s + t,
                    std::remainder(measured, 2.0 * std::numbers::pi), logged_rate);
      text += row;
    }
    for (int i = 0; i < kSubsteps; ++i) {
      const auto k1 = slope(angle, rate), k2 = slope(angle + 0.5 * h * k1[0], rate + 0.5 * h * k1[1]),
                 k3 = slope(angle + 0.5 * h * k2[0], rate + 0.5 * h * k2[1]),
                 k4 = slope(angle + h * k3[0], rate + h * k3[1]);
      angle += h / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]);
      rate += h / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]);
    }
  }
  return text;
}

}  // namespace nlo::trainer
