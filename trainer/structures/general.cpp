// SPDX-License-Identifier: MIT
// General observer (11): z' = F(z, y), x_hat = G(z), both networks. F starts as D z + F y of a stable linear system.
#include <fmt/format.h>

#include "trainer/base/draws.h"
#include "trainer/config/key_error.h"
#include "trainer/structures/dynamics_network.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/general_lanes.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

/// Returns the linear system from which F starts. Its eigenvalues are initial values, not parameters.
LatentShape starting_system(const ObserverStructure& structure) {
  LatentShape shape = structure.latent;
  shape.learned = shape.rows;
  return shape;
}

class General final : public TrainableStructure {
 public:
  std::string_view name() const override { return "general"; }

  void check(const Experiment& experiment, const ChannelCounts&) const override {
    const ObserverConfig& o = experiment.observer;
    if (!o.clocks_s.empty())
      throw KeyError("observer.clocks_s",
                     "[observer] clocks_s adds rows of D, but the general observer has no D: remove it");
    if (o.features != FeatureSet::kLatent)
      throw KeyError("observer.features",
                     fmt::format("[observer] features is \"{}\", but G of the general observer reads only z; "
                                 "remove it",
                                 to_name(o.features)));
    check_zero_start(o, "the general observer");
    check_linear_latent(experiment);
  }

  void vary(Experiment& experiment, Draws& draws) const override { vary_widths(experiment.dynamics.hidden, draws); }

  bool has_dynamics_network() const override { return true; }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    add_modes(structure, experiment.observer);
    add_features(structure, experiment.observer);
    structure.latent.learned = 0;
    const int nz = structure.latent.rows;
    structure.dynamics = dynamics_network(experiment.dynamics, nz + structure.readings, nz, true);
  }

  /// Normalises z of the linear system (with mean 0) and y.
  void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool& pool) const override {
    std::vector<Moments> inputs(structure.dynamics.inputs.scale.size());
    const auto nz = static_cast<std::size_t>(structure.latent.rows);
    for (const TrainingData::Run& run : data.runs) add_signal(run.readings, run.samples, nz, inputs);

    const LatentShape start = starting_system(structure);
    LinearLatent linear(start, structure.eigenvalues, data.steps_s, true);
    linear.prepare(parameters_from_eigenvalues(start, structure.eigenvalues.data()).data());
    Rollout rollout(data);
    rollout.run(whole_runs(data), linear, {}, 0, Purpose::kValidationNoise, 0, pool);
    for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
      for (std::size_t r = 0; r < nz; ++r)
        inputs[r].add(
            static_cast<double>(group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)]),
            1.0);
    });
    for (std::size_t r = 0; r < nz; ++r) inputs[r].mean = 0.0;
    structure.dynamics.inputs = normalisation_by(inputs);
  }

  /// Sets F(z, y) = D z + F y initially: only the linear path, in the units of its inputs.
  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) const override {
    const NetworkShape& shape = structure.dynamics.shape;
    const Normalisation& inputs = structure.dynamics.inputs;
    std::vector<float> parameters = initial_parameters(shape, experiment.seed, 0.0F, kDynamicsStream);
    float* bias = parameters.data() + shape.layers.back().bias;
    const auto set = [&](int row, int column, double value) {
      const auto c = static_cast<std::size_t>(column);
      parameters[static_cast<std::size_t>(shape.linear_path + row * shape.inputs() + column)] =
          static_cast<float>(value * inputs.scale[c]);
      bias[row] += static_cast<float>(value * inputs.mean[c]);
    };
    for (const Mode& mode : structure.latent.modes) {
      const std::complex<double> lambda = eigenvalue_of(mode, structure.eigenvalues);
      const std::complex<double> f = injection_of(structure.latent.injection, mode, lambda);
      set(mode.row, mode.row, lambda.real());
      if (mode.reading >= 0) set(mode.row, structure.latent.rows + mode.reading, f.real());
      if (!mode.pair) continue;
      set(mode.row, mode.row + 1, -lambda.imag());
      set(mode.row + 1, mode.row, lambda.imag());
      set(mode.row + 1, mode.row + 1, lambda.real());
      if (mode.reading >= 0) set(mode.row + 1, structure.latent.rows + mode.reading, f.imag());
    }
    return parameters;
  }

  std::unique_ptr<OdeDynamics<float>> lanes(const ObserverStructure& structure) const override {
    return lanes_of<float>(structure);
  }
  std::unique_ptr<OdeDynamics<double>> lanes_in_double(const ObserverStructure& structure) const override {
    return lanes_of<double>(structure);
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment&, const Dataset&,
                codegen::Model& model) const override {
    model.structure = codegen::General{.dynamics = dynamics_of(structure.dynamics, parameters),
                                       .inverse_map = inverse_map_of(structure, parameters, 0)};
  }

 private:
  template <class Scalar>
  static std::unique_ptr<OdeDynamics<Scalar>> lanes_of(const ObserverStructure& structure) {
    return std::make_unique<GeneralLanes<Scalar>>(structure.readings, structure.dynamics.shape,
                                                  structure.dynamics.inputs);
  }
};

}  // namespace

const TrainableStructure& general_structure() {
  static const General kModule;
  return kModule;
}

}  // namespace nlo::trainer
