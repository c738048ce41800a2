// SPDX-License-Identifier: MIT
// Carried observer (nlo/carried_observer.h): z' = D z + F y - w x z for vectors, x_hat = sum_k c_k z_k. The eigenvalues
// of D and the weights c are learned; the rotation is known.
#include "codegen/model/carried.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/carried_latent.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

using codegen::kAxes;

/// Keys of [observer] that only this structure has.
struct CarriedConfig {
  bool unit_length = false;
};

void refuse(const char* key, const std::string& why) {
  throw KeyError(key, why);
}

/// Refuses keys of the experiment that vectors cannot have.
void check_keys(const Experiment& experiment) {
  const ObserverConfig& o = experiment.observer;
  for (const auto& [key, given] : {std::pair{"observer.pairs", !o.pairs.empty()},
                                   {"observer.clocks_s", !o.clocks_s.empty()},
                                   {"training.gradient", experiment.training.gradient != LatentGradient::kAutomatic}})
    if (given)
      refuse(key,
             fmt::format("{} has no effect on a carried observer, which filters vectors by real eigenvalues; remove it",
                         key));
  if (o.features == FeatureSet::kLatentMinusOutput)
    refuse("observer.features",
           "[observer] features of a carried observer must be \"latent\" or \"latent_and_output\"");
  const InverseMapConfig& map = experiment.inverse_map;
  if (!map.hidden.empty() || !map.linear_path || map.error || map.readout != ReadoutChoice::kNetwork)
    refuse("inverse_map",
           "[inverse_map] of a carried observer must be a sum of vectors, so that the estimate rotates with the "
           "sensor: write hidden = [], linear_path = true, readout = \"network\", and remove error");
}

void check_channels(const Experiment& experiment, const ChannelCounts& channels) {
  const auto vectors = [](const char* what, int count) {
    if (count == 0 || count % kAxes != 0)
      refuse("observer.structure", fmt::format("a carried observer needs vectors of three components, but there are {} "
                                               "{}: list x, y, z of each vector in this order",
                                               count, what));
  };
  vectors("outputs", channels.outputs);
  vectors("states", channels.states);
  for (const codegen::Channel& output : channels.output_channels)
    if (output.wrap > 0.0)
      refuse("observer.structure",
             fmt::format("{} is an angle, but a carried observer only has components of vectors; use another structure",
                         output.name));
  if (channels.read_inputs != kAxes)
    refuse("observer.structure",
           fmt::format("a carried observer needs the rate of rotation as three inputs (x, y, z in rad/s), but there "
                       "are {} inputs: give the gyroscope's columns role = \"input\", and other columns another role",
                       channels.read_inputs));
  if (!experiment.log) return;
  for (const ColumnConfig& column : experiment.log->columns)
    if (column.role == ColumnRole::kInput && column.unit != "rad/s")
      refuse("observer.structure", fmt::format("input {} has the unit \"{}\", but a rate of rotation must be in rad/s: "
                                               "write unit = \"rad/s\", and file_unit if the file has another unit",
                                               column.name, column.unit));
}

class CarriedStructure final : public TrainableStructure {
 public:
  std::string_view name() const override { return "carried"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    return {own_key<ObserverConfig>(key("unit_length", &CarriedConfig::unit_length, any(),
                                        "carried: scale estimated vectors to length 1 (a direction)"))};
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    check_linear_latent(experiment);
    check_keys(experiment);
    check_channels(experiment, channels);
  }

  bool has_eigenvalues() const override { return true; }
  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    const ObserverConfig& observer = experiment.observer;
    structure.axes = kAxes;
    structure.centred = true;
    LatentShape& latent = structure.latent;
    latent.injection = observer.output_injection;
    latent.starts_steady = observer.start == LatentStart::kSteady;
    for (int j = 0; j < structure.outputs(); ++j)
      for (const double lambda : observer.eigenvalues) {
        latent.modes.push_back({.pair = false, .row = latent.rows++, .reading = j});
        structure.eigenvalues.push_back(lambda);
      }
    latent.learned = latent.rows;
    const auto modes = static_cast<int>(observer.eigenvalues.size());
    for (int j = 0; j < structure.outputs(); j += kAxes)
      for (int mode = 0; mode < modes; ++mode)
        for (int c = 0; c < kAxes; ++c) structure.features.push_back({.latent = (j + c) * modes + mode});
    if (observer.features == FeatureSet::kLatentAndOutput)
      for (int j = 0; j < structure.outputs(); ++j)
        structure.features.push_back({.latent = -1, .reading = j, .reading_gain = 1.0F});
  }

  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment&) const override {
    return parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data());
  }

  std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                                  const std::vector<double>& steps_s, int) const override {
    return std::make_unique<CarriedLatent>(structure.latent, structure.outputs(), structure.eigenvalues, steps_s,
                                           !experiment.observer.learn_eigenvalues);
  }

  /// Gives every component the same eigenvalues and weights.
  void constrain(const ObserverStructure& structure, float* parameters) const override {
    const int outputs = structure.outputs(), modes = structure.latent.rows / outputs;
    for (int m = 0; m < modes; ++m) {
      float sum = 0.0F;
      for (int j = 0; j < outputs; ++j) sum += parameters[j * modes + m];
      for (int j = 0; j < outputs; ++j) parameters[j * modes + m] = sum / static_cast<float>(outputs);
    }
    const NetworkShape& map = structure.network;
    float* own = parameters + structure.dynamics_parameters();
    same_for_each_component(own + map.layers[0].weights, map.outputs(), map.inputs());
    std::fill_n(own + map.layers[0].bias, map.outputs(), 0.0F);
    same_for_each_component(own + map.linear_path, map.outputs(), map.inputs());
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    const LatentShape& latent = structure.latent;
    const Eigen::Index modes = latent.rows / structure.outputs();
    const std::vector<double> eigenvalues = structure.eigenvalues_at(parameters);
    codegen::Carried own{.component = {}, .inverse_map = inverse_map_of(structure, parameters, model.nr())};
    own.unit_length = experiment.observer.own.get<CarriedConfig>().unit_length;
    own.component.eigenvalues = Eigen::Map<const Eigen::VectorXd>(eigenvalues.data(), modes);
    own.component.output_injection.resize(modes, 1);
    for (Eigen::Index m = 0; m < modes; ++m)
      own.component.output_injection(m, 0) =
          injection_of(latent.injection, latent.modes[static_cast<std::size_t>(m)], own.component.eigenvalues(m))
              .real();
    own.component.starts_steady = latent.starts_steady;
    model.structure = std::move(own);
  }

  /// Sets ranges that also hold for a rotated sensor: each component gets the largest range of all components,
  /// symmetric about 0.
  void complete(const ObserverStructure& structure, codegen::Model& model) const override {
    const Eigen::Index modes = structure.latent.rows / structure.outputs();
    const auto widen = [](Eigen::VectorXd& low, Eigen::VectorXd& high, Eigen::Index first, Eigen::Index stride) {
      double most = 0.0;
      for (Eigen::Index c = 0; c < kAxes; ++c)
        most = std::max({most, std::abs(low(first + c * stride)), std::abs(high(first + c * stride))});
      for (Eigen::Index c = 0; c < kAxes; ++c) {
        low(first + c * stride) = -most;
        high(first + c * stride) = most;
      }
    };
    widen(model.input_min, model.input_max, 0, 1);
    for (Eigen::Index j = 0; j < model.ny(); j += kAxes) {
      widen(model.output_min, model.output_max, j, 1);
      for (Eigen::Index m = 0; m < modes; ++m) widen(model.latent_min, model.latent_max, j * modes + m, modes);
    }
  }

 private:
  /// Fills the weights between components of outputs and inputs, row by row: c for the same component, else 0.
  static void same_for_each_component(float* weights, int outputs, int inputs) {
    for (int o = 0; o < outputs; o += kAxes)
      for (int i = 0; i < inputs; i += kAxes) {
        const auto at = [&](int a, int b) -> float& { return weights[(o + a) * inputs + i + b]; };
        const float mean = (at(0, 0) + at(1, 1) + at(2, 2)) / 3.0F;
        for (int a = 0; a < kAxes; ++a)
          for (int b = 0; b < kAxes; ++b) at(a, b) = a == b ? mean : 0.0F;
      }
  }
};

}  // namespace

const TrainableStructure& carried_structure() {
  static const CarriedStructure kModule;
  return kModule;
}

}  // namespace nlo::trainer
