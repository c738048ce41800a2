// SPDX-License-Identifier: MIT
// The calls of an observer of ../flown_model.h, and of its monitor with NLO_MONITORED. Each is a function.
#include "bench/embedded/worst_case/calls.h"

#include <cstddef>

#include "bench/embedded/flown_model.h"
#if NLO_MONITORED
#include <nlo/monitor.h>
#endif

namespace {

volatile float estimated;
volatile int status;

/// The observer and its monitor. Each begins with the pointer to its model.
struct Flown {
  Observer observer{kModel};
#if NLO_MONITORED
  nlo::Monitor<nlo::NLO_MODEL::MonitorModel, Arithmetic::NLO_ARITHMETIC> monitor{nlo::NLO_MODEL::kMonitor};
#endif
};
constinit Flown flown;

template <class Values>
Values values(const float* from) {
  Values result{};
  for (int i = 0; i < static_cast<int>(result.size()); ++i) result[i] = from[i];
  return result;
}

template <class... Dt>
void called_step(Dt... dt_s) {
  status = static_cast<int>(
      step(flown.observer, values<Observer::Output>(call_y), values<Observer::Input>(call_u), dt_s...));
}

constexpr float kLongest = kModel.sample_period_s * static_cast<float>(Observer::Model::kLongestGap);

#if NLO_MONITORED
constexpr unsigned kSecondPointer = offsetof(Flown, monitor) - sizeof(void*);
using Estimate = decltype(flown.observer.estimate());
#else
constexpr unsigned kSecondPointer = sizeof(Flown) - sizeof(void*);
#endif
constexpr int kPointer = static_cast<int>(sizeof(void*));

}  // namespace

float call_y[16], call_u[16], call_dt_s;

extern const CalledObserver called = {
    .outputs = static_cast<int>(Observer::Output{}.size()),
    .inputs = Observer::kDriven ? static_cast<int>(Observer::Input{}.size()) : 0,
    .state = reinterpret_cast<unsigned char*>(&flown) + kPointer,
    .bytes = sizeof(Flown) - kPointer,
    .lowest = kModel.outputs.min[0],
    .highest = kModel.outputs.max[0],
    .sample_period_s = kModel.sample_period_s,
    .longest = kLongest,
    .pointer = kSecondPointer,
};

void call_step() {
  called_step();
}

void call_step_dt() {
  called_step(call_dt_s);
}

void call_estimate() {
  for (const float value : flown.observer.estimate()) estimated = value;
}

#if NLO_MONITORED
void call_usable_outputs() {
  for (const float value : flown.monitor.usable_outputs(values<Observer::Output>(call_y), flown.observer))
    estimated = value;
}

void call_watch() {
  status = static_cast<int>(flown.monitor.watch(flown.observer, values<Estimate>(call_u)));
}
#endif
