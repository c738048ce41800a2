// SPDX-License-Identifier: MIT
#include "trainer/optim/optimiser.h"

#include <cmath>
#include <numbers>

#include "codegen/error.h"

namespace nlo::trainer {

double schedule_factor(const TrainingConfig& config, long step) {
  if (config.schedule == "constant") return 1.0;
  if (config.schedule == "exponential") return std::pow(config.decay, static_cast<double>(step));
  if (config.schedule == "cosine") {
    return 0.5 * (1.0 + std::cos(std::numbers::pi * static_cast<double>(step) / config.steps));
  }
  throw codegen::Error("unknown schedule \"" + config.schedule + "\"; use constant, exponential or cosine");
}

std::vector<std::string> schedule_names() {
  return {"constant", "exponential", "cosine"};
}
std::vector<std::string> optimiser_names() {
  return {"adam", "gradient_descent"};
}

Optimiser::Optimiser(const std::string& name, std::vector<ParameterGroup> groups)
    : adam_(name == "adam"), groups_(std::move(groups)) {
  if (!adam_ && name != "gradient_descent") {
    throw codegen::Error("unknown optimiser \"" + name + "\"; use adam or gradient_descent");
  }
  std::size_t count = 0;
  for (const ParameterGroup& group : groups_) count += static_cast<std::size_t>(group.count);
  if (adam_) memory_.assign(2 * count, 0.0F);
}

void Optimiser::step(float* parameters, const float* gradient, long step, double factor) {
  adam_ ? adam(parameters, gradient, step, factor) : gradient_descent(parameters, gradient, factor);
}

/// Kingma and Ba 2015, with decoupled weight decay (Loshchilov and Hutter 2019).
void Optimiser::adam(float* p, const float* g, long step, double factor) {
  constexpr float kBeta1 = 0.9F;
  constexpr float kBeta2 = 0.999F;
  constexpr float kEpsilon = 1e-8F;
  const double t = static_cast<double>(step) + 1.0;
  const auto correct1 = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(kBeta1), t)));
  const auto correct2 = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(kBeta2), t)));
  float* m = memory_.data();
  float* v = m + memory_.size() / 2;
  for (const ParameterGroup& group : groups_) {
    const auto rate = static_cast<float>(group.rate * factor);
    const auto keep = static_cast<float>(1.0 - group.rate * factor * group.weight_decay);
    for (int i = 0; i < group.count; ++i, ++p, ++g, ++m, ++v) {
      *m = kBeta1 * *m + (1.0F - kBeta1) * *g;
      *v = kBeta2 * *v + (1.0F - kBeta2) * *g * *g;
      *p = keep * *p - rate * (*m * correct1) / (std::sqrt(*v * correct2) + kEpsilon);
    }
  }
}

void Optimiser::gradient_descent(float* p, const float* g, double factor) {
  for (const ParameterGroup& group : groups_) {
    const auto rate = static_cast<float>(group.rate * factor);
    const auto keep = static_cast<float>(1.0 - group.rate * factor * group.weight_decay);
    for (int i = 0; i < group.count; ++i, ++p, ++g) *p = keep * *p - rate * *g;
  }
}

}  // namespace nlo::trainer
