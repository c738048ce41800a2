// SPDX-License-Identifier: MIT
// Observer with a prior (codegen/model/prior.h): the plant's known equations, corrected by gated units that learn.
#include "codegen/model/prior.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/data/log_schema.h"
#include "trainer/plants/equations_of_plant.h"
#include "trainer/rollout/sampling.h"
#include "trainer/structures/dynamics_network.h"
#include "trainer/structures/failing_sensors.h"
#include "trainer/structures/known_equations.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/prior_lanes.h"
#include "trainer/structures/prior_start.h"
#include "trainer/structures/trainable_structure.h"
#include "trainer/structures/unit_settings.h"
#include "trainer/structures/units_latent.h"

namespace nlo::trainer {
namespace {

/// Returns the known plant: the simulated one, or the one beside the logs; null without one.
const PlantConfig* known_plant(const Experiment& experiment) {
  if (experiment.plant) return &*experiment.plant;
  return experiment.known ? &experiment.known->plant : nullptr;
}

/// Returns the plant's equations. Inputs that the observer does not read are 0. Beside logs the inputs are those of the
/// logs, and the plant need not have all of them.
KnownEquations equations_of_plant(const Experiment& experiment, bool reads_inputs) {
  const PlantConfig plant = equations_of(*known_plant(experiment));
  std::vector<std::string> inputs;
  if (reads_inputs && experiment.known)
    for (const codegen::Channel& input : resolve_columns(*experiment.log).input_channels) inputs.push_back(input.name);
  return known_equations(plant, reads_inputs, experiment.known ? inputs : plant.inputs);
}

/// Returns the range at a start of each state that nobody estimates, from the box of [simulation].
std::vector<codegen::Interval> start_box(const Experiment& experiment, const std::vector<std::string>& unestimated) {
  const PlantConfig& plant = *known_plant(experiment);
  const SimulationConfig& simulation = experiment.known ? experiment.known->simulation : experiment.simulation;
  std::vector<codegen::Interval> box;
  for (const std::string& name : unestimated)
    for (std::size_t i = 0; i < plant.states.size() && i < simulation.initial_low.size(); ++i) {
      const codegen::Interval range(simulation.initial_low[i], simulation.initial_high[i]);
      if (name == plant.states[i]) box.push_back(range);
      if (name == plant.states[i] + "_sin") box.push_back(value_of(codegen::Function::kSine, range));
      if (name == plant.states[i] + "_cos") box.push_back(value_of(codegen::Function::kCosine, range));
    }
  return box;
}

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

void refuse(const char* key, const std::string& why) {
  throw KeyError(key, why);
}

void check_plant(const Experiment& experiment, const ChannelCounts& channels) {
  if (known_plant(experiment) == nullptr)
    refuse("observer.structure",
           "[observer] structure \"prior\" needs the equations of [plant], but there are only logs; add the known "
           "equations, or use another structure");
  const PlantConfig& plant = *known_plant(experiment);
  const KnownEquations known = equations_of_plant(experiment, channels.read_inputs > 0);
  if (experiment.known && start_box(experiment, known.texts.unestimated).size() != known.texts.unestimated.size())
    refuse("simulation.initial_low",
           "[simulation] has no initial_low and initial_high, but a prior needs the range of each state that the logs "
           "do not have; give both, one number for each state");
  if (has_unwrapped_angle(plant))
    refuse("observer.structure",
           "a prior needs the sine and cosine of each angle in rad: set its wrap to \"2pi\" and its encoding to "
           "\"sincos\" in state_encodings or output_encodings of [plant], and in [[log.columns]]");
  if (experiment.known) {
    const LogSchema logs = resolve_columns(*experiment.log);
    const auto same = [](const std::vector<codegen::Channel>& logged, const std::vector<codegen::Channel>& own) {
      return std::ranges::equal(logged, own, {}, &codegen::Channel::name, &codegen::Channel::name);
    };
    const std::vector<codegen::Channel> estimated(
        known.states.begin(), known.states.end() - static_cast<std::ptrdiff_t>(known.texts.unestimated.size()));
    if (!same(logs.state_channels, estimated) || !same(logs.output_channels, known.outputs))
      refuse("plant",
             "a prior needs the channels of the logs: give [plant] states (or `estimated`, if some states have no "
             "column) and output_names the names of the state and output columns, in the same order");
  }
  try {
    const codegen::Equations equations(known.texts, known.states, known.inputs);
    if (equations.ny() != channels.outputs)
      refuse("plant.outputs",
             fmt::format(
                 "a prior needs an equation for each output, but [plant] has {} for {}; leave computed outputs out",
                 equations.ny(), channels.outputs));
  } catch (const codegen::Error& error) {
    refuse("plant", fmt::format("[plant] {}", error.what()));
  }
}

class PriorStructure final : public TrainableStructure {
 public:
  std::string_view name() const override { return "prior"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    std::vector<Key<ObserverConfig>> keys = failing_sensor_keys();
    for (Key<ObserverConfig>& of_units : unit_keys()) keys.push_back(std::move(of_units));
    return keys;
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    check_units(experiment, "an observer with a prior");
    check_failing_sensors(experiment, channels);
    check_plant(experiment, channels);
  }

  bool adopt(Experiment& experiment, double) const override {
    const PlantConfig* plant = known_plant(experiment);
    if (plant == nullptr || has_unwrapped_angle(*plant)) return false;
    experiment.observer = plain_observer_of(name(), experiment.observer);
    experiment.inverse_map.hidden = {16};
    experiment.inverse_map.linear_path = true;
    train_units(experiment);
    experiment.training.gradient_clip = 10.0;
    return true;
  }

  void vary(Experiment& experiment, Draws& draws) const override {
    vary_units(experiment.observer.own.set<UnitSettings>(), draws);
  }

  bool has_dynamics_network() const override { return true; }
  bool has_known_equations() const override { return true; }

  codegen::SensorFailures failures(const Experiment& experiment, const Dataset& training) const override {
    return failing_sensors(experiment, training);
  }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    const KnownEquations known = equations_of_plant(experiment, structure.inputs > 0);
    PriorSetting& own = structure.own.set<PriorSetting>();
    own.equations = codegen::Equations(known.texts, known.states, known.inputs);
    own.on_circle = known.on_circle;
    own.unestimated = static_cast<int>(known.texts.unestimated.size());
    own.start_box = start_box(experiment, known.texts.unestimated);
    own.units = experiment.observer.own.get<UnitSettings>().units;
    own.readings = structure.readings;
    own.inputs = structure.inputs;
    own.commands = experiment.observer.input_hold == Hold::kZeroOrder;
    own.whole_runs = trains_whole_runs(experiment.training);
    own.noisy = !std::ranges::all_of(experiment.training.all_noise().parts, &NoiseConfig::none);
    structure.latent.rows = own.units + own.carried();
    structure.dynamics = dynamics_network({.hidden = {}, .activation = "tanh"}, own.units + own.reads(),
                                          3 * own.units + own.corrections(), false);
    // T* does not read the covariance, because its values on other logs differ from those in training.
    for (int row = 0; row < own.units + own.estimated(); ++row) structure.features.push_back({.latent = row});
    if (experiment.observer.features == FeatureSet::kLatent) return;
    for (int j = 0; j < structure.readings; ++j)
      structure.features.push_back({.latent = -1, .reading = j, .reading_gain = 1.0F});
  }

  void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool&) const override {
    PriorSetting& own = structure.own.set<PriorSetting>();
    start_prior(own, data);
    const auto units = static_cast<std::ptrdiff_t>(own.units);
    std::copy(own.read.mean.begin(), own.read.mean.end(), structure.dynamics.inputs.mean.begin() + units);
    std::copy(own.read.scale.begin(), own.read.scale.end(), structure.dynamics.inputs.scale.begin() + units);
  }

  /// The tuned constants are a factor on the noise of all states, the noise variances of the states and of the outputs,
  /// and the first variances of the states.
  int tuned_constants(const ObserverStructure& structure) const override {
    const PriorSetting& own = structure.own.get<PriorSetting>();
    return 1 + own.nx() + own.ny() + own.nx();
  }

  void multiply_constants(ObserverStructure& structure, const Eigen::VectorXd& factors) const override {
    PriorSetting& own = structure.own.set<PriorSetting>();
    const int outputs = 1 + own.nx(), first = outputs + own.ny();
    for (int i = 0; i < own.nx(); ++i) own.state_noise[static_cast<std::size_t>(i)] *= factors(0) * factors(1 + i);
    for (int j = 0; j < own.ny(); ++j) own.output_noise[static_cast<std::size_t>(j)] *= factors(outputs + j);
    for (int i = 0; i < own.nx(); ++i) {
      const auto row = static_cast<std::size_t>(own.equations.place(i, i));
      own.start[row] = std::clamp(own.start[row] * factors(first + i), own.low[row], own.high[row]);
    }
  }

  int estimate_row(const ObserverStructure& structure, int state) const override {
    return structure.own.get<PriorSetting>().units + state;
  }

  /// The units start as those of a gated observer. All corrections start at zero, so that [x; p] are the estimate and
  /// the covariance of an extended Kalman filter.
  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) const override {
    const PriorSetting& own = structure.own.get<PriorSetting>();
    const LayerView& layer = structure.dynamics.shape.layers[0];
    std::vector<float> parameters =
        initial_parameters(structure.dynamics.shape, experiment.seed, 1.0F, kDynamicsStream);
    const std::vector<float> rates = initial_rates(experiment.observer.own.get<UnitSettings>(), own.period_s);
    std::copy(rates.begin(), rates.end(), parameters.begin() + layer.bias);
    const int first = 3 * own.units;
    std::fill_n(parameters.begin() + layer.weights + static_cast<std::ptrdiff_t>(first) * layer.in,
                own.corrections() * layer.in, 0.0F);
    std::fill_n(parameters.begin() + layer.bias + first, own.corrections(), 0.0F);
    return parameters;
  }

  std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment&, const ObserverStructure& structure,
                                                  const std::vector<double>& steps_s, int threads) const override {
    const PriorSetting& own = structure.own.get<PriorSetting>();
    return std::make_unique<UnitsLatent<PriorLanes<float>>>(
        structure.latent.rows, structure.dynamics.shape.parameters, own.period_s, steps_s, threads,
        [&own] { return std::make_unique<PriorLanes<float>>(own); });
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    const PriorSetting& own = structure.own.get<PriorSetting>();
    model.initial_latent.tail(own.carried()) = as_vector(own.start);
    codegen::Prior prior;
    prior.equations = equations_of_plant(experiment, own.inputs > 0).texts;
    prior.state_min = as_vector(own.low);
    prior.state_max = as_vector(own.high);
    prior.state_noise = as_vector(own.state_noise);
    prior.output_noise = as_vector(own.output_noise);
    prior.inverse_map = inverse_map_of(structure, parameters, model.nr());
    if (own.units > 0) {
      codegen::Network all = dynamics_of(structure.dynamics, parameters);
      all.output_scale.tail(own.corrections()) = as_vector(own.scale);
      prior.fine = as_vector(own.fine);
      prior.coarse = as_vector(own.coarse);
      prior.gates = rows_of(all, 0, 2 * own.units);
      prior.candidate = rows_of(all, 2 * own.units, own.units);
      prior.correction = rows_of(all, 3 * own.units, own.corrections());
    }
    model.structure = std::move(prior);
  }
};

}  // namespace

const TrainableStructure& prior_structure() {
  static const PriorStructure kModule;
  return kModule;
}

}  // namespace nlo::trainer
