// SPDX-License-Identifier: MIT
// An exported C++ observer with its monitor, used as in docs/runtime.md, behind plain functions that fly.py calls.
#include <flown.h>

#include <cmath>

namespace {

namespace flown = nlo::flown;
flown::Observer observer{flown::kModel};
flown::Monitor monitor{flown::kMonitor};

/// A template, so that only the call that fits this observer is compiled.
template <class Observer>
nlo::StepStatus step(Observer& flying, const typename Observer::Output& y, const float* u, float dt_s) {
  if constexpr (Observer::kDriven) {
    typename Observer::Input inputs{};
    for (int i = 0; i < inputs.size(); ++i) inputs[i] = u[i];
    return dt_s == 0.0F ? flying.step(y, inputs) : flying.step(y, inputs, dt_s);
  } else {
    return dt_s == 0.0F ? flying.step(y) : flying.step(y, dt_s);
  }
}

}  // namespace

extern "C" {

int flown_sizes(int* sizes) {
  sizes[0] = flown::Observer::kMeasured;
  sizes[1] = flown::Observer::kNu;
  sizes[2] = flown::Observer::kNx;
  return 0;
}

void flown_start() {
  observer.reset();
  monitor.reset();
}

/// Steps one sample. dt_s = 0: one sample period. Returns bits: 0 the status is not to be trusted, 1 outside of the
/// domain, 2 alarm, 3 the gate rejected a reading, 4 the monitor is armed, 5 to 7 the alarm.
int flown_sample(const float* y, const float* u, float dt_s, int gated, float* x_hat) {
  flown::Observer::Output outputs{};
  for (int j = 0; j < outputs.size(); ++j) outputs[j] = y[j];
  flown::Observer::Output kept = outputs;
  if (gated != 0) kept = monitor.usable_outputs(outputs, observer, dt_s);
  const nlo::StepStatus status = step(observer, kept, u, dt_s);
  const auto estimate = observer.estimate();
  const nlo::Alarm alarm = monitor.watch(observer, estimate);
  bool rejected = false;
  for (int j = 0; j < outputs.size(); ++j) rejected = rejected || (std::isfinite(outputs[j]) && outputs[j] != kept[j]);
  for (int i = 0; i < estimate.size(); ++i) x_hat[i] = estimate[i];
  return static_cast<int>(status >= nlo::StepStatus::kStale) | (observer.in_domain() ? 0 : 2) |
         (alarm != nlo::Alarm::kNone ? 4 : 0) | (rejected ? 8 : 0) | (monitor.armed() ? 16 : 0) |
         static_cast<int>(alarm) << 5;
}

}  // extern "C"
