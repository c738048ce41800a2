// SPDX-License-Identifier: MIT
#include "trainer/structures/linear_latent_start.h"

#include <fmt/format.h>

#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"

namespace nlo::trainer {

void check_linear_latent(const Experiment& experiment) {
  const ObserverConfig& o = experiment.observer;
  if (o.eigenvalues.empty() && o.pairs.empty())
    throw KeyError("observer",
                   "[observer] has no latent states; give eigenvalues = [-1.0, ...] or pairs = [[-1.0, 2.0], ...]");
  for (std::size_t i = 0; i < o.pairs.size(); ++i) {
    const auto& [re, im] = o.pairs[i];
    if (!(re < 0.0))
      throw KeyError("observer.pairs",
                     fmt::format("[observer] pairs[{}] has the real part {}; it must be < 0", i, shortest_text(re)));
    if (!(im > 0.0))
      throw KeyError("observer.pairs",
                     fmt::format("[observer] pairs[{}] has the imaginary part {}; it must be > 0 (its "
                                 "conjugate is meant too); a real eigenvalue belongs in eigenvalues",
                                 i, shortest_text(im)));
  }
  const double period = experiment.plant ? experiment.simulation.sample_period_s : experiment.log->sample_period_s;
  if (period > 0.0) check_latent_step(o, period);
}

void check_latent_step(const ObserverConfig& observer, double sample_period_s) {
  if (observer.hold != Hold::kRk4) return;
  const auto check = [&](std::complex<double> lambda, const std::string& shown) {
    const auto x = lambda * sample_period_s;
    const auto factor = 1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)));
    if (std::abs(factor) < 1.0) return;
    throw KeyError("observer.hold",
                   fmt::format("unstable step: hold = \"rk4\" multiplies the latent state of eigenvalue {} by {:.3g} "
                               "in every sample of {} s; use a smaller sample period (|lambda| h < 2.78), or hold = "
                               "\"first_order\"",
                               shown, std::abs(factor), shortest_text(sample_period_s)));
  };
  for (const double lambda : observer.eigenvalues) check(lambda, shortest_text(lambda));
  for (const auto& [re, im] : observer.pairs)
    check({re, im}, fmt::format("{} +- {}i", shortest_text(re), shortest_text(im)));
}

void check_zero_start(const ObserverConfig& observer, const char* what) {
  if (observer.start != LatentStart::kZero)
    throw KeyError("observer.start", fmt::format("[observer] start is \"{}\", but {} starts from z = 0; remove it",
                                                 to_name(observer.start), what));
}

void add_modes(ObserverStructure& structure, const ObserverConfig& observer) {
  LatentShape& latent = structure.latent;
  latent.injection = observer.output_injection;
  latent.starts_steady = observer.start == LatentStart::kSteady;
  const int driving = structure.outputs() + structure.inputs;  // a staleness is read unchanged
  for (int j = 0; j < driving; ++j) {
    for (const auto& [re, im] : observer.pairs) {
      latent.modes.push_back({.pair = true, .row = latent.rows, .reading = j});
      latent.rows += 2;
      structure.eigenvalues.insert(structure.eigenvalues.end(), {re, im});
    }
  }
  for (int j = 0; j < driving; ++j) {
    for (const double lambda : observer.eigenvalues) {
      latent.modes.push_back({.pair = false, .row = latent.rows++, .reading = j});
      structure.eigenvalues.push_back(lambda);
    }
  }
  latent.learned = latent.rows;
  for (const double tau_s : observer.clocks_s) {
    latent.modes.push_back({.pair = false, .row = latent.rows++, .reading = -1});
    structure.eigenvalues.push_back(-1.0 / tau_s);
  }
  if (latent.learned == 0) throw codegen::Error("the observer has no eigenvalues: set [observer] eigenvalues or pairs");
}

void add_features(ObserverStructure& structure, const ObserverConfig& observer) {
  const bool relative = observer.features == FeatureSet::kLatentMinusOutput;
  for (const Mode& mode : structure.latent.modes) {
    Feature feature{.latent = mode.row};
    if (relative && mode.reading >= 0 &&
        mode.reading < structure.outputs()) {  // unit gain: the steady state of a pair is (y, 0), of a real mode y
      feature.reading = mode.reading;
      feature.reading_gain = -1.0F;
    }
    structure.features.push_back(feature);
    if (mode.pair) structure.features.push_back({.latent = mode.row + 1});
  }
  const int driving = structure.outputs() + structure.inputs;
  // T* also reads the latest input itself, because an input acts without a delay.
  if (observer.features != FeatureSet::kLatent) {
    for (int j = relative ? structure.outputs() : 0; j < driving; ++j)
      structure.features.push_back({.latent = -1, .reading = j, .reading_gain = 1.0F});
  }
  for (int j = driving; j < structure.readings; ++j)
    structure.features.push_back({.latent = -1, .reading = j, .reading_gain = 1.0F});
}

void add_clock_products(ObserverStructure& structure, ClockProductSet set) {
  if (set == ClockProductSet::kNone) return;
  const std::size_t plain = structure.features.size();
  const int driving = structure.outputs() + structure.inputs;
  for (std::size_t clock = 0; clock < plain; ++clock) {
    if (!is_clock(structure, structure.features[clock])) continue;
    for (std::size_t f = 0; f < plain; ++f) {
      Feature product = structure.features[f];
      if (is_clock(structure, product) || product.reading >= driving) continue;  // a staleness is read unchanged
      if (set == ClockProductSet::kLatent && product.latent < 0) continue;
      product.clock = structure.features[clock].latent;
      product.without = static_cast<int>(f);
      structure.features.push_back(product);
    }
  }
}

std::complex<double> eigenvalue_of(const Mode& mode, const std::vector<double>& eigenvalues) {
  const auto row = static_cast<std::size_t>(mode.row);
  return {eigenvalues[row], mode.pair ? eigenvalues[row + 1] : 0.0};
}

}  // namespace nlo::trainer
