// SPDX-License-Identifier: MIT
// Fake observers with one output and with several, whose z, readings and statuses a test sets.
#pragma once

#include <cmath>

#include "nlo/monitor.h"

namespace nlo::monitor_tests {

inline constexpr double kNone = 1e9;   // a limit that nothing exceeds
inline constexpr int kArmedAfter = 4;  // samples after which the monitor of quiet_model() is armed

/// An observer that only holds unusable readings.
struct Fake {
  static constexpr int kNx = 1, kNz = 1, kNr = 1;
  struct Outputs {
    double wrap[1] = {0.0};
  };
  struct Model {
    double sample_period_s = 0.01;
    Outputs outputs = {};
  };
  struct State {
    int started = 1;
    double y[1] = {0.0};
    StepStatus status = StepStatus::kOk;
  };
  Model own{};
  double y = 0.0, z = 0.0;
  int started = 1;
  StepStatus last = StepStatus::kOk;     // status of the latest step
  StepStatus reading = StepStatus::kOk;  // health of its output

  constexpr const Model& model() const { return own; }
  constexpr State save() const { return {started, {y}, last}; }
  constexpr StepStatus status(int /*output*/) const { return reading; }
  constexpr Vector<double, 1> relative_latent() const { return {{z}}; }
};

using Model = MonitorModel<double, 1, 1, 1, 1, 2>;

/// A monitor's model: deviation 2; the prediction is that y returns to 0: e = y / 2. Windows of 10 and 50 samples.
inline Model quiet_model() {
  Model m{};
  m.prediction[0][1] = -0.5;
  m.per_deviation[0] = 0.5;
  m.least_variance[0] = 0.01;
  m.per_latent_deviation[0] = 1.0;
  for (int w = 0; w < 2; ++w) {
    m.gain[w] = -std::expm1(-1.0 / (w == 0 ? 10.0 : 50.0));
    m.mean_limit[0][w] = m.variance_limit[0][w] = m.correlation_limit[0][w] = m.latent_limit[w] = kNone;
  }
  m.missing_limit[0] = kNone;
  m.gate_squared = 16.0;
  m.armed_after = kArmedAfter;
  return m;
}

inline Alarm seen(Monitor<Model>& monitor, Fake& observer, double y) {
  const double kept = monitor.usable_outputs(y, observer);
  if (!std::isnan(kept)) observer.y = kept;
  return monitor.watch(observer, Vector<double, 1>{{0.0}});
}

/// Two outputs, of which the first is an angle; three latent coordinates, three readings, two states, three windows.
struct Wide {
  using Model = MonitorModel<double, 2, 2, 3, 3, 3>;
  static constexpr int kNx = 2, kNz = 3, kNr = 3;
  struct Outputs {
    double wrap[3] = {0.75, 0.0, 0.0};
  };
  struct Own {
    double sample_period_s = 0.01;
    Outputs outputs = {};
  };
  struct State {
    int started = 1;
    double y[3];
    StepStatus status = StepStatus::kOk;
  };
  Own own{};
  double y[3] = {}, z[3] = {};

  const Own& model() const { return own; }
  State save() const { return {1, {y[0], y[1], y[2]}, StepStatus::kOk}; }
  StepStatus status(int /*output*/) const { return StepStatus::kOk; }
  Vector<double, 3> relative_latent() const { return {{z[0], z[1], z[2]}}; }
};

}  // namespace nlo::monitor_tests
