// SPDX-License-Identifier: MIT
// Roll-outs outside of training steps: of the flight segments, of the draw of a step, and of whole runs.
#include "trainer/learn/training/objective.h"

#include <utility>

#include "trainer/rollout/sampling.h"

namespace nlo::trainer {

const Rollout& Objective::roll_out_flight(const float* parameters) {
  roll_out(parameters, flight_segments(*experiment_, *data_), Purpose::kValidationNoise, 0);
  return rollout_;
}

const Rollout& Objective::roll_out_draw(const float* parameters, long step) {
  roll_out(parameters, draw_segments(*experiment_, *data_, step), Purpose::kNoise, step);
  return rollout_;
}

const Rollout& Objective::roll_out_runs(const float* parameters) {
  std::vector<Segment> runs = whole_runs(*data_);
  for (Segment& run : runs_with_failures(*data_, experiment_->training.dropout)) runs.push_back(std::move(run));
  roll_out(parameters, runs, Purpose::kValidationNoise, 0);
  return rollout_;
}

}  // namespace nlo::trainer
