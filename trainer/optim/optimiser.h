// SPDX-License-Identifier: MIT
// Optimisers and learning-rate schedules. A new one is one entry in the tables of optimiser.cpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Learning rate at a step, relative to the configured one: 1 at first.
double schedule_factor(const TrainingConfig& config, long step);

/// Names for configs and messages.
std::vector<std::string> schedule_names();
std::vector<std::string> optimiser_names();

/// What one parameter needs: its own rate (relative) and decay.
struct ParameterGroup {
  int count = 0;
  double rate = 0.0;          ///< learning rate
  double weight_decay = 0.0;  ///< decoupled: p -= rate * weight_decay * p
};

/// First-order optimisers; `memory` is their state, to be saved with a checkpoint.
class Optimiser {
 public:
  Optimiser(const std::string& name, std::vector<ParameterGroup> groups);

  /// parameters <- parameters - rate * direction(gradient).
  void step(float* parameters, const float* gradient, long step, double factor);

  std::vector<float>& memory() { return memory_; }

 private:
  void adam(float* p, const float* g, long step, double factor);
  void gradient_descent(float* p, const float* g, double factor);

  bool adam_ = true;
  std::vector<ParameterGroup> groups_;
  std::vector<float> memory_;  // Adam: first and second moments, one after the other
};

}  // namespace nlo::trainer
