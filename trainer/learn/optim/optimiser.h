// SPDX-License-Identifier: MIT
// Optimisers and learning-rate schedules. To add one, add an entry to a table of optimiser.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// The learning rate and the weight decay of a group of parameters.
struct ParameterGroup {
  int count = 0;
  double rate = 0.0;          ///< learning rate
  double weight_decay = 0.0;  ///< decoupled: p -= rate * weight_decay * p
};

/// A first-order optimiser: parameters <- parameters - rate * direction(gradient), group by group.
struct OptimiserEntry {
  std::string_view name;              ///< value of [training] optimiser
  std::size_t numbers_per_parameter;  ///< numbers that it stores for each parameter, initially zero
  void (*step)(const std::vector<ParameterGroup>& groups, float* parameters, const float* gradient, long step,
               double factor, std::vector<float>& memory);
};

/// A schedule of the learning rate.
struct ScheduleEntry {
  std::string_view name;  ///< value of [training] schedule
  /// Returns the rate at a step, relative to the configured rate. It is 1 at first.
  double (*factor)(const TrainingConfig& config, double step);
};

const std::vector<OptimiserEntry>& optimisers();
const std::vector<ScheduleEntry>& schedules();

/// Returns the names for keys and messages.
std::vector<std::string> optimiser_names();
std::vector<std::string> schedule_names();

/// Returns the factor of the configured schedule at a step. An unknown name throws codegen::Error, which lists the
/// known ones.
double schedule_factor(const TrainingConfig& config, long step);

/// If the Euclidean norm of a gradient is above `largest`, scales the gradient to that norm. 0: no limit. Source:
/// Pascanu et al. 2013.
void clip(std::vector<float>& gradient, double largest);

/// An optimiser with its memory, which a checkpoint stores. An unknown name throws codegen::Error, which lists the
/// known ones.
class Optimiser {
 public:
  Optimiser(const std::string& name, std::vector<ParameterGroup> groups);

  void step(float* parameters, const float* gradient, long step, double factor);

  std::vector<float>& memory() { return memory_; }

  /// Sets the first moments to zero, so that the next step has no momentum. The second moments stay, so that this step
  /// is no longer than usual.
  void forget_direction();

 private:
  const OptimiserEntry* entry_;
  std::vector<ParameterGroup> groups_;
  std::vector<float> memory_;
};

}  // namespace nlo::trainer
