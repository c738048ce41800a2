// SPDX-License-Identifier: MIT
// Gated observer (nlo/gated_observer.h): z' = rate (target - z), with learned rates and targets, starting at z = 0.
#include "codegen/model/gated.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/dynamics_network.h"
#include "trainer/structures/failing_sensors.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/trainable_structure.h"
#include "trainer/structures/unit_settings.h"
#include "trainer/structures/units_latent.h"

namespace nlo::trainer {
namespace {

/// Keys of [observer] that only a gated observer has.
struct GatedConfig {
  double contraction = 0.0;  ///< > 0: limit of the units' coupling (codegen/model/contraction.h), below 1
};

/// The sample period [s], which is the unit of the rates.
struct GatedPeriod {
  double s = 0.0;
};

/// The limit that constrain() enforces: GatedConfig::contraction.
struct CouplingLimit {
  double value = 0.0;
};

class Gated final : public TrainableStructure {
 public:
  std::string_view name() const override { return "gated"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    std::vector<Key<ObserverConfig>> keys = failing_sensor_keys();
    for (Key<ObserverConfig>& of_units : unit_keys()) keys.push_back(std::move(of_units));
    keys.push_back(own_key<ObserverConfig>(key("contraction", &GatedConfig::contraction, between(0, 0.999),
                                               "gated: limit of the coupling between units, below 1, so that z "
                                               "provably forgets its initial value; 0: no limit")));
    return keys;
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    check_units(experiment, "a gated observer");
    if (experiment.observer.own.get<UnitSettings>().units == 0)
      throw KeyError("observer.units",
                     "[observer] units is 0, but a gated observer is made of units; give it at least one, or use "
                     "structure = \"prior\", which without units is an extended Kalman filter");
    check_failing_sensors(experiment, channels);
  }

  /// Uses the settings of van_der_pol_gated; the rates are derived from the sample period.
  bool adopt(Experiment& experiment, double) const override {
    experiment.observer = plain_observer_of(name(), experiment.observer);
    experiment.inverse_map.hidden = {32};
    experiment.inverse_map.linear_path = false;
    train_units(experiment);
    return true;
  }

  void vary(Experiment& experiment, Draws& draws) const override {
    vary_units(experiment.observer.own.set<UnitSettings>(), draws);
  }

  bool has_dynamics_network() const override { return true; }
  bool learns_to_average_noise() const override { return true; }

  codegen::SensorFailures failures(const Experiment& experiment, const Dataset& training) const override {
    return failing_sensors(experiment, training);
  }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    const int units = experiment.observer.own.get<UnitSettings>().units;
    structure.latent.rows = units;
    structure.own.set<CouplingLimit>().value = experiment.observer.own.get<GatedConfig>().contraction;
    structure.dynamics =
        dynamics_network({.hidden = {}, .activation = "tanh"}, units + structure.readings, 3 * units, false);
    for (int row = 0; row < units; ++row) structure.features.push_back({.latent = row});
    if (experiment.observer.features == FeatureSet::kLatent) return;
    for (int j = 0; j < structure.readings; ++j)
      structure.features.push_back({.latent = -1, .reading = j, .reading_gain = 1.0F});
  }

  /// Normalises the readings. z is between -1 and 1, and a staleness between 0 and 1.
  void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool&) const override {
    structure.own.set<GatedPeriod>().s = data.sample_period_s;
    const auto units = static_cast<std::size_t>(structure.latent.rows);
    std::vector<Moments> given(units + static_cast<std::size_t>(data.given()));
    for (const TrainingData::Run& run : data.runs) add_signal(run.readings, run.samples, units, given);
    const Normalisation found = normalisation_by(given);
    for (std::size_t i = units; i < given.size(); ++i) {
      structure.dynamics.inputs.mean[i] = found.mean[i];
      structure.dynamics.inputs.scale[i] = found.scale[i];
    }
  }

  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) const override {
    const NetworkShape& shape = structure.dynamics.shape;
    std::vector<float> parameters = initial_parameters(shape, experiment.seed, 1.0F, kDynamicsStream);
    const std::vector<float> rates =
        initial_rates(experiment.observer.own.get<UnitSettings>(), structure.own.get<GatedPeriod>().s);
    std::copy(rates.begin(), rates.end(), parameters.begin() + shape.layers[0].bias);
    return parameters;
  }

  /// For each unit, reduces the weights of its rate and its target on z until the coupling of its row is within its
  /// limit.
  void constrain(const ObserverStructure& structure, float* parameters) const override {
    const double limit = structure.own.get<CouplingLimit>().value;
    if (limit == 0.0) return;
    const int units = structure.latent.rows;
    const LayerView& layer = structure.dynamics.shape.layers[0];
    const auto row = [&](int r) { return parameters + layer.weights + static_cast<std::ptrdiff_t>(r) * layer.in; };
    std::vector<double> reset(static_cast<std::size_t>(units));
    const auto sum = [units](const float* w) {
      double all = 0.0;
      for (int j = 0; j < units; ++j) all += std::abs(static_cast<double>(w[j]));
      return all;
    };
    for (int k = 0; k < units; ++k) reset[static_cast<std::size_t>(k)] = 1.0 + 0.5 * sum(row(units + k));
    for (int i = 0; i < units; ++i) {
      double coupling = 4.0 * sum(row(i));
      for (int k = 0; k < units; ++k)
        coupling += std::abs(static_cast<double>(row(2 * units + i)[k])) * reset[static_cast<std::size_t>(k)];
      if (coupling <= limit) continue;
      const auto less = static_cast<float>(limit / coupling);
      for (int j = 0; j < units; ++j) {
        row(i)[j] *= less;
        row(2 * units + i)[j] *= less;
      }
    }
  }

  std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment&, const ObserverStructure& structure,
                                                  const std::vector<double>& steps_s, int threads) const override {
    const int units = structure.latent.rows;
    Normalisation readings = structure.dynamics.inputs;
    readings.mean.erase(readings.mean.begin(), readings.mean.begin() + units);
    readings.scale.erase(readings.scale.begin(), readings.scale.begin() + units);
    return std::make_unique<UnitsLatent<GatedUnits<float>>>(
        units, structure.dynamics.shape.parameters, structure.own.get<GatedPeriod>().s, steps_s, threads,
        [&] { return std::make_unique<GatedUnits<float>>(units, readings); });
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment&, const Dataset&,
                codegen::Model& model) const override {
    const codegen::Network all = dynamics_of(structure.dynamics, parameters);
    const Eigen::Index units = structure.latent.rows;
    model.structure = codegen::Gated{.gates = rows_of(all, 0, 2 * units),
                                     .candidate = rows_of(all, 2 * units, units),
                                     .inverse_map = inverse_map_of(structure, parameters, model.nr())};
  }

  /// Adds the proof of contraction for the weights that the file will have.
  void complete(const ObserverStructure& structure, codegen::Model& model) const override {
    if (structure.own.get<CouplingLimit>().value == 0.0) return;
    auto& gated = std::get<codegen::Gated>(model.structure);
    gated.contraction = codegen::find_contraction(model, gated);
  }
};

}  // namespace

const TrainableStructure& gated_structure() {
  static const Gated kModule;
  return kModule;
}

}  // namespace nlo::trainer
