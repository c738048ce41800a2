// SPDX-License-Identifier: MIT
#include "trainer/learn/optim/optimiser.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codegen/base/error.h"

namespace nlo::trainer {

namespace {

template <class Entry>
const Entry& entry_named(const std::vector<Entry>& entries, std::string_view name, const char* what) {
  std::string names;
  for (const Entry& entry : entries) {
    if (entry.name == name) return entry;
    if (!names.empty()) names += &entry == &entries.back() ? " or " : ", ";
    names += entry.name;
  }
  throw codegen::Error("unknown " + std::string(what) + " \"" + std::string(name) + "\"; use " + names);
}

template <class Entry>
std::vector<std::string> names_of(const std::vector<Entry>& entries) {
  std::vector<std::string> names;
  for (const Entry& entry : entries) names.emplace_back(entry.name);
  return names;
}

/// Kingma and Ba 2015, with decoupled weight decay (Loshchilov and Hutter 2019).
void adam(const std::vector<ParameterGroup>& groups, float* p, const float* g, long step, double factor,
          std::vector<float>& memory) {
  constexpr float kBeta1 = 0.9F;
  constexpr float kBeta2 = 0.999F;
  constexpr float kEpsilon = 1e-8F;
  const double t = static_cast<double>(step) + 1.0;
  const auto correct1 = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(kBeta1), t)));
  const auto correct2 = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(kBeta2), t)));
  float* m = memory.data();
  float* v = m + memory.size() / 2;
  for (const ParameterGroup& group : groups) {
    const auto rate = static_cast<float>(group.rate * factor);
    const auto keep = static_cast<float>(1.0 - group.rate * factor * group.weight_decay);
    for (int i = 0; i < group.count; ++i, ++p, ++g, ++m, ++v) {
      *m = kBeta1 * *m + (1.0F - kBeta1) * *g;
      *v = kBeta2 * *v + (1.0F - kBeta2) * *g * *g;
      *p = keep * *p - rate * (*m * correct1) / (std::sqrt(*v * correct2) + kEpsilon);
    }
  }
}

void gradient_descent(const std::vector<ParameterGroup>& groups, float* p, const float* g, long, double factor,
                      std::vector<float>&) {
  for (const ParameterGroup& group : groups) {
    const auto rate = static_cast<float>(group.rate * factor);
    const auto keep = static_cast<float>(1.0 - group.rate * factor * group.weight_decay);
    for (int i = 0; i < group.count; ++i, ++p, ++g) *p = keep * *p - rate * *g;
  }
}

double constant(const TrainingConfig&, double) {
  return 1.0;
}
double exponential(const TrainingConfig& config, double step) {
  return std::pow(config.decay, step);
}
double cosine(const TrainingConfig& config, double step) {
  return 0.5 * (1.0 + std::cos(std::numbers::pi * step / config.steps));
}

/// Three cosines, each twice as long as the one before: 1, 2 and 4 sevenths of the steps (Loshchilov and Hutter 2017).
double warm_restarts(const TrainingConfig& config, double step) {
  const double part = 7.0 * step / config.steps, from = part < 1.0 ? 0.0 : part < 3.0 ? 1.0 : 3.0;
  return 0.5 * (1.0 + std::cos(std::numbers::pi * (part - from) / (from + 1.0)));
}

}  // namespace

const std::vector<OptimiserEntry>& optimisers() {
  static const std::vector<OptimiserEntry> kEntries = {
      {"adam", 2, adam},  // stores the first moments, then the second moments
      {"gradient_descent", 0, gradient_descent},
  };
  return kEntries;
}

const std::vector<ScheduleEntry>& schedules() {
  static const std::vector<ScheduleEntry> kEntries = {
      {"constant", constant},
      {"exponential", exponential},
      {"cosine", cosine},
      {"warm_restarts", warm_restarts},
  };
  return kEntries;
}

std::vector<std::string> optimiser_names() {
  return names_of(optimisers());
}
std::vector<std::string> schedule_names() {
  return names_of(schedules());
}

double schedule_factor(const TrainingConfig& config, long step) {
  return entry_named(schedules(), config.schedule, "schedule").factor(config, static_cast<double>(step));
}

void clip(std::vector<float>& gradient, double largest) {
  double squares = 0.0;
  for (const float g : gradient) squares += static_cast<double>(g) * static_cast<double>(g);
  if (largest == 0.0 || squares <= largest * largest) return;
  const auto factor = static_cast<float>(largest / std::sqrt(squares));
  for (float& g : gradient) g *= factor;
}

Optimiser::Optimiser(const std::string& name, std::vector<ParameterGroup> groups)
    : entry_(&entry_named(optimisers(), name, "optimiser")), groups_(std::move(groups)) {
  std::size_t count = 0;
  for (const ParameterGroup& group : groups_) count += static_cast<std::size_t>(group.count);
  memory_.assign(entry_->numbers_per_parameter * count, 0.0F);
}

void Optimiser::forget_direction() {
  if (entry_->numbers_per_parameter == 0) return;
  const std::size_t first_moments = memory_.size() / entry_->numbers_per_parameter;
  std::fill(memory_.begin(), memory_.begin() + static_cast<std::ptrdiff_t>(first_moments), 0.0F);
}

void Optimiser::step(float* parameters, const float* gradient, long step, double factor) {
  entry_->step(groups_, parameters, gradient, step, factor, memory_);
}

}  // namespace nlo::trainer
