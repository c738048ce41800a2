// SPDX-License-Identifier: MIT
// A program that only runs an exported observer at its sample period, to measure its size. It is compiled like
// fly_exported.cpp.
#include NLO_HEADER

namespace {

constinit nlo::NLO_MODEL::Observer observer{nlo::NLO_MODEL::kModel};
volatile float measured, estimated;
volatile int status;

template <class Observer>
void fly(Observer& flown) {
  typename Observer::Output y{};
  for (auto& value : y) value = measured;
  if constexpr (Observer::kDriven) {
    typename Observer::Input u{};
    for (auto& value : u) value = measured;
    status = static_cast<int>(flown.step(y, u));
  } else {
    status = static_cast<int>(flown.step(y));
  }
  for (const float value : flown.estimate()) estimated = value;
}

}  // namespace

int main() {
  for (;;) fly(observer);
}
