// SPDX-License-Identifier: MIT
// The classical Runge-Kutta method over values of Eigen, for simulated plants, filters and the reference observer.
// Flight and training use nlo/explicit_rk.h.
#pragma once

namespace nlo::codegen {

/// Returns z(t + h) of z' = slope(c, z), with c in [0, 1], the position in the step.
template <class State, class Scalar, class Slope>
State rk4_step(const State& z, Scalar h, const Slope& slope) {
  constexpr Scalar kHalf(0.5), kTwo(2);
  const State k1 = slope(Scalar(0), z);
  const State k2 = slope(kHalf, State(z + kHalf * h * k1));
  const State k3 = slope(kHalf, State(z + kHalf * h * k2));
  const State k4 = slope(Scalar(1), State(z + h * k3));
  return z + h / Scalar(6) * (k1 + kTwo * k2 + kTwo * k3 + k4);
}

}  // namespace nlo::codegen
