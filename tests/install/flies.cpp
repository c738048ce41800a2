// SPDX-License-Identifier: MIT
// A user's program: runs the exported observer, and reports whether Eigen was available.
#include <cstdio>

#include "van_der_pol.h"
#if WITH_EIGEN
#include <nlo/eigen.h>
#elif __has_include(<Eigen/Core>) || __has_include("Eigen/Core")
#error "Eigen is on the include path"
#endif

constinit static nlo::van_der_pol::Observer observer{nlo::van_der_pol::kModel};

int main() {
  for (int k = 0; k < 3; ++k) static_cast<void>(observer.step(0.5F));
#if WITH_EIGEN
  const auto x_hat = observer.estimate();
  std::printf("norm %g\n", static_cast<double>(nlo::as_eigen(x_hat).norm()));
#else
  std::printf("%g\n", static_cast<double>(observer.estimate()[0]));
#endif
}
