// SPDX-License-Identifier: MIT
// Undamped oscillator, the simplest linear plant: dx1/dt = x2, dx2/dt = -omega^2 x1 + u, y = x1. Without u, omega^2
// x1^2 + x2^2 is constant along every trajectory.
#include "trainer/plants/builtin.h"
#include "trainer/plants/linear.h"

namespace nlo::trainer {

std::unique_ptr<Plant> make_harmonic_oscillator(const PlantParameters& parameters) {
  const double omega = parameters[0].second;
  Eigen::MatrixXd a(2, 2), c(1, 2);
  a << 0.0, 1.0, -omega * omega, 0.0;
  c << 1.0, 0.0;
  return std::make_unique<LinearPlant>("harmonic_oscillator", channels({"x1", "x2"}), channels({"y"}), a, c,
                                       channels({"u"}), Eigen::Vector2d(0.0, 1.0));
}

}  // namespace nlo::trainer
