// SPDX-License-Identifier: MIT
#include "trainer/reproduce/hyperkkl_cells.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace nlo::trainer::reproduction {

double DrivenInput::operator()(double time_s) const {
  switch (kind) {
    case InputSignal::kConstant:
      return amplitude;
    case InputSignal::kSine:
      return amplitude * std::sin(frequency * time_s + phase);
    case InputSignal::kSquare: {
      const double wave = std::sin(frequency * time_s);
      return wave == 0.0 ? 0.0 : std::copysign(amplitude, wave);
    }
    default:
      return 0.0;
  }
}

DrivenInput draw_input(const InputRange& range, RunRandom& random) {
  DrivenInput input{range.kind};
  input.amplitude = random.between(range.least, range.most);
  if (range.sign && random.uniform() < 0.5) input.amplitude = -input.amplitude;
  input.frequency = random.between(range.slowest, range.fastest);
  if (range.kind == InputSignal::kSine) input.phase = 2.0 * std::numbers::pi * random.uniform();
  return input;
}

Eigen::MatrixXd latin_hypercube(const SimulationConfig& simulation, Eigen::Index count, RunRandom& random) {
  Eigen::MatrixXd x(static_cast<Eigen::Index>(simulation.initial_low.size()), count);
  std::vector<Eigen::Index> slices(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    std::iota(slices.begin(), slices.end(), Eigen::Index{0});
    for (std::size_t last = slices.size(); last > 1; --last) std::swap(slices[last - 1], slices[random.index(last)]);
    const double low = simulation.initial_low[static_cast<std::size_t>(i)];
    const double width = (simulation.initial_high[static_cast<std::size_t>(i)] - low) / static_cast<double>(count);
    for (Eigen::Index run = 0; run < count; ++run)
      x(i, run) = low + width * (static_cast<double>(slices[static_cast<std::size_t>(run)]) + random.uniform());
  }
  return x;
}

}  // namespace nlo::trainer::reproduction
