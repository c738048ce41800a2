// SPDX-License-Identifier: MIT
// KKL observer (16): z' = D z + F y, x_hat = T*(z). The eigenvalues of D are learned with T*. Its sensors may fail.
#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/base/draws.h"
#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/failing_sensors.h"
#include "trainer/structures/kkl_family.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {
namespace {

class Kkl final : public KklFamily {
 public:
  std::string_view name() const override { return "kkl"; }

  bool may_read_clock_products() const override { return true; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    std::vector<Key<ObserverConfig>> keys = failing_sensor_keys();
    keys.push_back(own_key<ObserverConfig>(
        key("saturation", &KklConfig::saturation, at_least(0),
            "kkl: limits the z that T* reads to its domain plus this many half ranges; 0: no limit")));
    keys.push_back(
        own_key<ObserverConfig>(key("clock_products", &KklConfig::clock_products, names_of<ClockProductSet>(),
                                    "kkl: features that T* also reads multiplied by each of clocks_s, for smaller "
                                    "errors in the transient: none, features of z, or all")));
    return keys;
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    KklFamily::check(experiment, channels);
    check_failing_sensors(experiment, channels);
    if (experiment.observer.own.get<KklConfig>().clock_products != ClockProductSet::kNone &&
        experiment.observer.clocks_s.empty())
      throw KeyError("observer.clock_products",
                     "[observer] clock_products multiplies by the clocks of clocks_s, but there are none; give "
                     "clocks_s = [...], or remove clock_products");
  }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    KklFamily::make(experiment, structure);
    add_clock_products(structure, experiment.observer.own.get<KklConfig>().clock_products);
  }

  codegen::SensorFailures failures(const Experiment& experiment, const Dataset& training) const override {
    return failing_sensors(experiment, training);
  }

  /// Sets real modes with the time constants of a gated observer's units, or with time constants derived from the
  /// sample period.
  bool adopt(Experiment& experiment, double sample_period_s) const override {
    constexpr double kSlowest = 0.01, kFastest = 0.25;  // per sample period
    constexpr int kModes = 4;
    ObserverConfig& o = experiment.observer;
    o = plain_observer_of(name(), o);
    for (int i = 0; i < kModes; ++i)
      o.eigenvalues.push_back(
          -rounded(kSlowest / sample_period_s * std::pow(kFastest / kSlowest, static_cast<double>(i) / (kModes - 1))));
    o.output_injection = Injection::kUnitGain;
    o.start = LatentStart::kSteady;
    o.features = FeatureSet::kLatentAndOutput;
    experiment.inverse_map.linear_path = true;
    experiment.training.gradient_clip = 0.0;
    experiment.training.samples_per_step = std::min(experiment.training.samples_per_step, 4096);
    return true;
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    model.structure = kkl_of(structure, parameters, experiment.observer, model);
    model.saturation = experiment.observer.own.get<KklConfig>().saturation;
  }
};

}  // namespace

const TrainableStructure& kkl_structure() {
  static const Kkl kModule;
  return kModule;
}

}  // namespace nlo::trainer
