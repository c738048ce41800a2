// SPDX-License-Identifier: MIT
// A pendulum whose logs are simulated here, and its identification file.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "codegen/reference/rk4.h"
#include "trainer/data/dataset.h"
#include "trainer/experiments/load_identification.h"

namespace nlo::trainer::test {

inline constexpr double kSquare = 20.0, kDamping = 0.4, kAngleNoise = 0.01;

/// angle'' = -w2 sin(angle) - c rate + u
inline const std::string kPendulumIdentification = R"(name = "pendulum"

[plant]
states = ["angle", "rate"]
inputs = ["u"]
derivative = ["rate", "-w2 * sin(angle) - c * rate + u"]
output_names = ["angle"]
outputs = ["angle"]
parameters = { w2 = 15.0, c = 1.0 }

[identify]
segment_s = 2.0
noise = { angle = 0.01 }
initial_state = [0.0, 0.0]
initial_deviation = [1.0, 5.0]
process_noise = [0.01, 0.1]
positive = ["w2"]

[log]
train_files = ["a.csv"]

[[log.columns]]
name = "time"
role = "time"

[[log.columns]]
name = "angle"
role = "output"
wrap = "2pi"

[[log.columns]]
name = "u"
role = "input"

[[log.columns]]
name = "rate"
role = "state"
)";

inline Identification pendulum_identification(const std::vector<std::string>& overrides = {}) {
  return parse_identification(kPendulumIdentification, "pendulum.toml", overrides);
}

/// Returns logs of 4 s with steps of 10 to 30 ms and wrapped angles. Only the angle has noise; u is a square wave of
/// amplitude 4.
inline Dataset pendulum_logs(unsigned seed, int logs = 2) {
  Dataset set{{{"angle", "rad", 2.0 * 3.141592653589793}}, {{"rate", "rad/s", 0.0}}, 0.02, false, {}};
  set.inputs = {{"u", "", 0.0}};
  std::mt19937 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine()) * 0x1p-32; };
  const auto normal = [&] {  // a sum of twelve uniform draws
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  };
  for (int log = 0; log < logs; ++log) {
    constexpr Eigen::Index kSamples = 201;
    Trajectory run{"log " + std::to_string(log), Eigen::VectorXd(kSamples), Eigen::MatrixXd(1, kSamples),
                   Eigen::MatrixXd(1, kSamples), Eigen::VectorXd::Ones(kSamples)};
    run.inputs.resize(1, kSamples);
    Eigen::Vector2d x(1.0 + uniform(), 8.0 * uniform() - 4.0);
    for (Eigen::Index k = 0; k < kSamples; ++k) {
      const double h = k == 0 ? 0.0 : 0.01 + 0.02 * uniform();
      run.time_s[k] = k == 0 ? 0.0 : run.time_s[k - 1] + h;
      run.inputs(0, k) = k / 20 % 2 == 0 ? 4.0 : -4.0;
      const double from = run.inputs(0, std::max<Eigen::Index>(0, k - 1)), to = run.inputs(0, k);
      constexpr int kFiner = 10;  // factor by which these steps are finer than those of the identification
      for (int i = 0; i < kFiner; ++i)
        x = codegen::rk4_step(x, h / kFiner, [&](double c, const Eigen::Vector2d& at) {
          const double u = from + (to - from) * (i + c) / kFiner;
          return Eigen::Vector2d(at[1], -kSquare * std::sin(at[0]) - kDamping * at[1] + u);
        });
      run.outputs(0, k) = x[0] + kAngleNoise * normal();
      run.states(0, k) = x[1];
    }
    set.trajectories.push_back(run);
  }
  return set;
}

}  // namespace nlo::trainer::test
