// SPDX-License-Identifier: MIT
// Reference for the discretisation, the filter and its adjoint: the latent recurrence with std::complex and libm, one
// mode and one trajectory at a time.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "nlo/latent.h"
#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer::testing {

using Cd = std::complex<double>;

struct PlainStep {
  Cd a, b0, b1;
};

/// z+ = a z + b0 u_k + b1 u_{k+1} of dz/dt = lambda z + u, from closed forms; for RK4 from its stages.
inline PlainStep plain_step(Hold hold, Cd lambda, double h) {
  if (hold == Hold::kRk4) {
    const auto advance = [&](Cd z, double u0, double u1) {
      const auto f = [&](Cd at, double u) { return lambda * at + u; };
      const double middle = 0.5 * (u0 + u1);
      const Cd k1 = f(z, u0);
      const Cd k2 = f(z + 0.5 * h * k1, middle);
      const Cd k3 = f(z + 0.5 * h * k2, middle);
      const Cd k4 = f(z + h * k3, u1);
      return z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    };
    return {advance(1.0, 0.0, 0.0), advance(0.0, 1.0, 0.0), advance(0.0, 0.0, 1.0)};
  }
  const Cd w = lambda * h;
  const Cd a = std::exp(w);
  const Cd phi1 = (a - 1.0) / w;
  if (hold == Hold::kZeroOrder) return {a, h * phi1, 0.0};
  const Cd phi2 = (phi1 - 1.0) / w;
  return {a, h * (phi1 - phi2), h * phi2};
}

/// z of one mode at all samples, driven by f y, from rest or from the steady state of y_0.
inline std::vector<Cd> plain_filter(Hold hold, Cd lambda, Cd f, bool starts_steady, const std::vector<double>& y,
                                    const std::vector<double>& steps_s, int ahead = 0) {
  std::vector<Cd> z{starts_steady ? -f / lambda * y[0] : 0.0};
  for (std::size_t k = 0; k + 1 < y.size(); ++k) {
    const PlainStep step = plain_step(hold, lambda, steps_s[k]);
    z.push_back(step.a * z.back() + f * (step.b0 * y[k + static_cast<std::size_t>(ahead)] + step.b1 * y[k + 1]));
  }
  return z;
}

/// Entry of F for a mode: 1 (1 + i for a pair), or -lambda.
inline Cd plain_injection(Injection injection, bool pair, Cd lambda) {
  if (injection == Injection::kUnitGain) return -lambda;
  return pair ? Cd{1.0, 1.0} : Cd{1.0, 0.0};
}

}  // namespace nlo::trainer::testing
