// SPDX-License-Identifier: MIT
// KKL observer (16): z' = D z + F y, x_hat = T*(z). The eigenvalues of D are learned with T*.
#include "trainer/structures/kkl_family.h"

namespace nlo::trainer {
namespace {

class Kkl final : public KklFamily {
 public:
  std::string_view name() const override { return "kkl"; }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    model.structure = kkl_of(structure, parameters, experiment.observer, model);
  }
};

}  // namespace

const TrainableStructure& kkl_structure() {
  static const Kkl kModule;
  return kModule;
}

}  // namespace nlo::trainer
