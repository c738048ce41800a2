// SPDX-License-Identifier: MIT
// Driven KKL observer (24)-(25): z' = D z + F y + phi(z) u, x_hat = T*(z), phi(z) = dT/dx(x_hat) g(x_hat). It is
// trained as the KKL observer of the undriven plant, with T beside T*. Both maps are used in flight.
#include "trainer/config/key_error.h"
#include "trainer/structures/kkl_family.h"
#include "trainer/structures/model_networks.h"

namespace nlo::trainer {
namespace {

class DrivenKkl final : public KklFamily {
 public:
  std::string_view name() const override { return "driven_kkl"; }
  bool flies_forward_map() const override { return true; }
  bool flies_inputs() const override { return true; }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    if (!experiment.plant || channels.inputs == 0)
      throw KeyError("observer.structure",
                     "[observer] structure = \"driven_kkl\" needs a plant with inputs; name them in [plant] inputs, or "
                     "use structure = \"kkl\"");
    KklFamily::check(experiment, channels);
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset& dataset, codegen::Model& model) const override {
    model.structure = codegen::DrivenKkl{{kkl_of(structure, parameters, experiment.observer, model)},
                                         dataset.inputs,
                                         experiment.observer.input_hold,
                                         dataset.input_field,
                                         forward_map_of(structure, parameters)};
  }
};

}  // namespace

const TrainableStructure& driven_kkl_structure() {
  static const DrivenKkl kModule;
  return kModule;
}

}  // namespace nlo::trainer
