// SPDX-License-Identifier: MIT
#include "trainer/structures/unit_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/base/draws.h"
#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {

std::vector<Key<ObserverConfig>> unit_keys() {
  return {
      own_key<ObserverConfig>(
          key("units", &UnitSettings::units, between(0, 1024),
              "gated, prior: number of gated units; prior with 0: an extended Kalman filter, and nothing else")),
      own_key<ObserverConfig>(key(
          "rates", &UnitSettings::rates, positive(),
          "gated, prior: slowest and fastest initial rate of the units [1/s]; empty: 0.01 and 0.5 per sample period"))};
}

void vary_units(UnitSettings& units, Draws& draws) {
  constexpr int kVector = 8;  // number of floats in a register of a kernel
  const double count = units.units * draws.one_of({0.5, 0.75, 1.0, 1.0, 1.5, 2.0});
  units.units = std::clamp(static_cast<int>(std::lround(count / kVector)) * kVector, kVector, 1024);
  const double faster = draws.one_of({0.5, 1.0, 1.0, 2.0});
  for (double& rate : units.rates) rate = rounded(faster * rate);
}

void train_units(Experiment& experiment) {
  TrainingConfig& t = experiment.training;
  t.trajectories_per_step = std::min(t.trajectories_per_step, 16);
  t.samples_per_step = std::max(t.samples_per_step, 8192);
  t.learning_rate = 1e-2;
  t.eigenvalue_learning_rate = 0.0;
  t.gradient_clip = 1.0;
  t.transient = Transient::kKeep;
}

void check_units(const Experiment& experiment, const char* what) {
  const ObserverConfig& o = experiment.observer;
  const auto refuse = [](const char* key, const std::string& why) {
    throw KeyError(fmt::format("observer.{}", key), fmt::format("[observer] {} {}; remove it", key, why));
  };
  for (const auto& [key, given] : {std::pair{"eigenvalues", !o.eigenvalues.empty()},
                                   {"pairs", !o.pairs.empty()},
                                   {"clocks_s", !o.clocks_s.empty()}})
    if (given) refuse(key, fmt::format("has no effect on {}, whose units learn their rates", what));
  if (o.hold != Hold::kFirstOrder)
    refuse("hold", fmt::format("has no effect on {}, which steps with the latest y", what));
  if (o.features == FeatureSet::kLatentMinusOutput)
    refuse("features", "compares z with y, but gated units are not in the units of y");
  check_zero_start(o, what);
  if (experiment.training.gradient != LatentGradient::kAutomatic)
    throw KeyError("training.gradient",
                   "[training] gradient selects the gradient of a differential equation, but gated units are stepped "
                   "exactly; remove it");
  const auto& [units, rates] = o.own.get<UnitSettings>();
  if (units == 0 && !rates.empty()) refuse("rates", "has no effect without units");
  if (!rates.empty() && (rates.size() != 2 || rates[0] > rates[1]))
    throw KeyError(
        "observer.rates",
        "[observer] rates must be the slowest and the fastest rate in 1/s, such as [0.5, 20.0]; or remove it");
}

std::vector<float> initial_rates(const UnitSettings& settings, double period_s) {
  std::vector<double> rates = settings.rates;
  if (rates.empty()) rates = {0.01 / period_s, 0.5 / period_s};
  std::vector<float> biases;
  for (int r = 0; r < settings.units; ++r) {
    const double part = settings.units > 1 ? static_cast<double>(r) / (settings.units - 1) : 0.5;
    const double rate = rates[0] * std::pow(rates[1] / rates[0], part);
    biases.push_back(static_cast<float>(0.5 * std::log(std::expm1(rate * period_s))));
  }
  return biases;
}

}  // namespace nlo::trainer
