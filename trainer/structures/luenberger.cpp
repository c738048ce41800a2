// SPDX-License-Identifier: MIT
// Luenberger-like observer (15) of a plant whose linear part is known:
//   x_hat' = A x_hat + B u + g_hat(x_hat) + G (y - C x_hat),  z = x_hat
#include <fmt/format.h>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/dynamics_network.h"
#include "trainer/structures/luenberger_lanes.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/observer_gain.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

class Luenberger final : public TrainableStructure {
 public:
  std::string_view name() const override { return "luenberger"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    using L = LuenbergerConfig;
    const auto own = [](Key<L> key) { return own_key<ObserverConfig>(std::move(key)); };
    return {
        own(key("state_matrix", &L::state_matrix, any(), "luenberger: A of the known linear part, row by row")),
        own(key("output_matrix", &L::output_matrix, any(), "luenberger: C of y = C x, row by row")),
        own(key("input_matrix", &L::input_matrix, any(), "luenberger: B of the known inputs, row by row")),
        own(key("gain", &L::gain, any(),
                "luenberger: gain G, row by row; gain_poles or gain_noise can design it instead")),
        own(key("gain_poles", &L::gain_poles, negative(),
                "luenberger: real eigenvalues for A - G C, one for each state")),
        own(key("gain_noise", &L::gain_noise, positive(),
                "luenberger: intensities [process, measurement] for the stationary Kalman gain")),
    };
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    const ObserverConfig& o = experiment.observer;
    for (const auto& [key, given] : {std::pair{"eigenvalues", !o.eigenvalues.empty()},
                                     {"pairs", !o.pairs.empty()},
                                     {"clocks_s", !o.clocks_s.empty()},
                                     {"start", o.start != LatentStart::kZero}})
      if (given)
        throw KeyError(fmt::format("observer.{}", key),
                       fmt::format("[observer] {} is not used by a Luenberger observer, whose latent state is the "
                                   "estimate; remove it",
                                   key));
    linear_part(o.own.get<LuenbergerConfig>(), channels.states, channels.outputs, channels.read_inputs);
  }

  bool has_dynamics_network() const override { return true; }
  bool has_inverse_map() const override { return false; }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    const int nx = static_cast<int>(structure.state_mean.size());
    structure.latent.rows = nx;
    structure.own.set<LinearPart>() =
        linear_part(experiment.observer.own.get<LuenbergerConfig>(), nx, structure.outputs(), structure.inputs);
    structure.dynamics = dynamics_network(experiment.dynamics, nx, nx, false);
  }

  void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool&) const override {
    std::vector<Moments> inputs(structure.dynamics.inputs.scale.size());
    for (const TrainingData::Run& run : data.runs) add_signal(run.states, run.samples, 0, inputs);
    structure.dynamics.inputs = normalisation_by(inputs);
  }

  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) const override {
    return initial_parameters(structure.dynamics.shape, experiment.seed, 1.0F, kDynamicsStream);
  }

  std::unique_ptr<OdeDynamics<float>> lanes(const ObserverStructure& structure) const override {
    return lanes_of<float>(structure);
  }
  std::unique_ptr<OdeDynamics<double>> lanes_in_double(const ObserverStructure& structure) const override {
    return lanes_of<double>(structure);
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment&, const Dataset&,
                codegen::Model& model) const override {
    const LinearPart& known = structure.own.get<LinearPart>();
    model.structure = codegen::Luenberger{.state_matrix = known.state_matrix,
                                          .output_matrix = known.output_matrix,
                                          .gain = known.gain,
                                          .nonlinearity = dynamics_of(structure.dynamics, parameters),
                                          .input_matrix = known.input_matrix};
  }

 private:
  template <class Scalar>
  static std::unique_ptr<OdeDynamics<Scalar>> lanes_of(const ObserverStructure& structure) {
    return std::make_unique<LuenbergerLanes<Scalar>>(structure.own.get<LinearPart>(), structure.dynamics.shape,
                                                     structure.dynamics.inputs);
  }
};

}  // namespace

const TrainableStructure& luenberger_structure() {
  static const Luenberger kModule;
  return kModule;
}

}  // namespace nlo::trainer
