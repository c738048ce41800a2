// SPDX-License-Identifier: MIT
// The strict test of a model on new trajectories of its own plant, by the experiment that the model carries.
#pragma once

#include <string>
#include <vector>

#include "codegen/model.h"
#include "trainer/analysis/evaluate.h"
#include "trainer/config.h"

namespace nlo::trainer {

/// The experiment a model was trained by. `origin` names the model's file. Throws codegen::Error when it has none.
Experiment experiment_of(const codegen::Model& model, const std::string& origin);

struct StrictTest {
  std::vector<NoiseConfig> noises;
  std::vector<std::string> against;  ///< ekf, constant
  unsigned long long seed = 1;       ///< of the initial states and the noise
  int trajectories = 200;
  double box_scale = 1.0;                ///< initial states from the training box times this
  int threads = 0;                       ///< 0: all cores
  std::vector<std::string> inputs = {};  ///< what excites the plant, see parse_excitation; empty: nothing
};

/// Per noise the observer and then its alternatives. Throws codegen::Error when a trajectory leaves the numbers.
std::vector<std::vector<Evaluation>> run_strict_test(const codegen::Model& model, const Experiment& experiment,
                                                     const StrictTest& test);

}  // namespace nlo::trainer
