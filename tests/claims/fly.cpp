// SPDX-License-Identifier: MIT
// Runs an exported header in a user's loop: reads one measurement per line and writes one estimate per line.
//   in   dt_s y... u...     dt_s 0: the sample period; angles as a sensor shows them
//   out  status in_domain x_hat...
// Compiled with NLO_HEADER, the header, and NLO_MODEL, its namespace in nlo.
#include NLO_HEADER

#include <cstdio>
#include <cstdlib>

namespace {

constinit nlo::NLO_MODEL::Observer observer{nlo::NLO_MODEL::kModel};

template <class Scalar>
bool read(Scalar& value) {
  double number = 0.0;
  if (std::scanf("%lf", &number) != 1) return false;
  value = static_cast<Scalar>(number);
  return true;
}

template <class Values>
bool read_all(Values& values) {
  for (auto& value : values)
    if (!read(value)) return false;
  return true;
}

/// A template, so that only the branch that fits the observer is compiled.
template <class Observer>
int fly(Observer& flown) {
  typename Observer::Scalar dt_s = 0;
  while (read(dt_s)) {
    typename Observer::Output y{};
    if (!read_all(y)) return EXIT_FAILURE;
    nlo::StepStatus status{};
    if constexpr (Observer::kDriven) {
      typename Observer::Input u{};
      if (!read_all(u)) return EXIT_FAILURE;
      status = dt_s > 0 ? flown.step(y, u, dt_s) : flown.step(y, u);
    } else {
      status = dt_s > 0 ? flown.step(y, dt_s) : flown.step(y);
    }
    std::printf("%d %d", static_cast<int>(status), flown.in_domain() ? 1 : 0);
    for (const auto value : flown.estimate()) std::printf(" %.9g", static_cast<double>(value));
    std::printf("\n");
  }
  return EXIT_SUCCESS;
}

}  // namespace

int main() {
  return fly(observer);
}
