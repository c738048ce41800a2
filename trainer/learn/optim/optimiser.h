// SPDX-License-Identifier: MIT
// Optimisers and learning-rate schedules. A new one is one entry in the tables of optimiser.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// The rate (relative) and decay of a group of parameters.
struct ParameterGroup {
  int count = 0;
  double rate = 0.0;          ///< learning rate
  double weight_decay = 0.0;  ///< decoupled: p -= rate * weight_decay * p
};

/// A first-order optimiser: parameters <- parameters - rate * direction(gradient), group by group.
struct OptimiserEntry {
  std::string_view name;              ///< value of [training] optimiser
  std::size_t numbers_per_parameter;  ///< size of its memory per parameter, zero at first
  void (*step)(const std::vector<ParameterGroup>& groups, float* parameters, const float* gradient, long step,
               double factor, std::vector<float>& memory);
};

/// A schedule of the learning rate.
struct ScheduleEntry {
  std::string_view name;  ///< value of [training] schedule
  /// The rate at a step, relative to the configured one: 1 at first.
  double (*factor)(const TrainingConfig& config, double step);
};

const std::vector<OptimiserEntry>& optimisers();
const std::vector<ScheduleEntry>& schedules();

/// Names for configs and messages.
std::vector<std::string> optimiser_names();
std::vector<std::string> schedule_names();

/// The configured schedule at a step. Throws codegen::Error with the names there are.
double schedule_factor(const TrainingConfig& config, long step);

/// Scales a gradient whose Euclidean norm is above `largest` down to it; 0: leaves it. Source: Pascanu et al. 2013.
void clip(std::vector<float>& gradient, double largest);

/// The optimiser of that name with its memory, which is saved with a checkpoint. Throws codegen::Error likewise.
class Optimiser {
 public:
  Optimiser(const std::string& name, std::vector<ParameterGroup> groups);

  void step(float* parameters, const float* gradient, long step, double factor);

  std::vector<float>& memory() { return memory_; }

  /// First moments at zero: the next step has no momentum. Second moments stay, so that it is no longer than usual.
  void forget_direction();

 private:
  const OptimiserEntry* entry_;
  std::vector<ParameterGroup> groups_;
  std::vector<float> memory_;
};

}  // namespace nlo::trainer
