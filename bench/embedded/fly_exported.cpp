// SPDX-License-Identifier: MIT
// An exported observer, compiled separately. The macros NLO_HEADER and NLO_MODEL are its header and its namespace.
#include "bench/embedded/fly_exported.h"

#include <utility>

#include NLO_HEADER

namespace {

using Observer = nlo::NLO_MODEL::Observer;
using Estimate = decltype(std::declval<const Observer&>().estimate());

constinit Observer observer{nlo::NLO_MODEL::kModel};

template <class Values>
Values values(const float* from) {
  Values result{};
  for (int i = 0; i < static_cast<int>(result.size()); ++i) result[i] = from[i];
  return result;
}

/// A template, so that the branch for other observers is not compiled.
template <class Flown>
nlo::StepStatus step(Flown& one, float dt_s, const float* measured, const float* given) {
  const auto y = values<typename Flown::Output>(measured);
  if constexpr (Flown::kDriven) {
    const auto u = values<typename Flown::Input>(given);
    return dt_s > 0 ? one.step(y, u, dt_s) : one.step(y, u);
  } else {
    static_cast<void>(given);
    return dt_s > 0 ? one.step(y, dt_s) : one.step(y);
  }
}

template <class Flown>
constexpr int input_count() {
  if constexpr (Flown::kDriven)
    return static_cast<int>(typename Flown::Input{}.size());
  else
    return 0;
}

}  // namespace

extern const FlownObserver flown = {static_cast<int>(Observer::Output{}.size()), input_count<Observer>(),
                                    static_cast<int>(Estimate{}.size()), sizeof(Observer)};

int step_and_estimate(float dt_s, const float* y, const float* u, float* x_hat) {
  const nlo::StepStatus status = step(observer, dt_s, y, u);
  const auto estimate = observer.estimate();
  for (int i = 0; i < static_cast<int>(estimate.size()); ++i) x_hat[i] = estimate[i];
  return static_cast<int>(status);
}

bool in_domain() {
  return observer.in_domain();
}
