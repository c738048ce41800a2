// SPDX-License-Identifier: MIT
// The smallest use of an exported observer: reads one measurement per line and prints estimates.
//   awk -F, 'NR > 1 {print $2}' log.csv | minimal
#include <cstdio>

#include "van_der_pol.h"  // generated: nlo export, or nlo_add_model() in CMake

constinit static nlo::van_der_pol::Observer observer{nlo::van_der_pol::kModel};

int main() {
  float position = 0.0F;
  while (std::scanf("%f", &position) == 1) {
    if (observer.step(position) != nlo::StepStatus::kOk) std::fputs("clamped or held\n", stderr);
    const auto x_hat = observer.estimate();
    std::printf("%.9g %.9g\n", static_cast<double>(x_hat[0]), static_cast<double>(x_hat[1]));
  }
}
