// SPDX-License-Identifier: MIT
#include "trainer/data/dataset.h"

namespace nlo::trainer {

void Dataset::compute_outputs() {
  const codegen::ComputedOutputs computed(outputs, reads_inputs ? inputs : std::vector<Channel>{});
  if (computed.none()) return;
  for (Trajectory& run : trajectories) {
    computed.fill(run.outputs, run.inputs);
    if (run.missing.size() == 0) continue;
    for (std::size_t i = 0; i < computed.all().size(); ++i) {
      auto missing = run.missing.row(computed.first() + static_cast<Eigen::Index>(i));
      missing.setConstant(false);
      for (const int part : computed.all()[i].reads())
        if (part < computed.first()) missing = missing || run.missing.row(part);
    }
  }
}

}  // namespace nlo::trainer
