// SPDX-License-Identifier: MIT
// The file of `nlo identify` as a value: a plant by expressions with unknown parameters, the logs to find them from,
// and the method. Defaults stand only here.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// [identify]
struct IdentifyConfig {
  double segment_s = 1.0;                                ///< length of the segments that are simulated
  int most_samples = 40000;                              ///< more are thinned: every n-th segment is taken
  std::vector<std::pair<std::string, double>> noise;     ///< standard deviation of each fitted output or state, by name
  std::vector<double> initial_state, initial_deviation;  ///< start of a segment and of the filters, n_x each
  std::vector<double> process_noise;                     ///< start of the filters' tuning, per sqrt(s), n_x
  std::vector<std::string> fixed, positive;              ///< parameters
  Hold input_hold = Hold::kFirstOrder;
  double longest_step_s = 0.0;         ///< longest step of RK4; 0: the sample period
  int iterations = 50;                 ///< most iterations of Levenberg and Marquardt's method
  std::vector<double> from_s = {0.0};  ///< times at which the filters start in each log
};

struct Identification {
  std::string name;
  int threads = 0;    ///< 0: all cores. The result does not depend on it.
  PlantConfig plant;  ///< by expressions; outputs may name the inputs; a parameter's range bounds it
  LogConfig log;      ///< columns by the plant's names
  IdentifyConfig identify;
  EvaluationConfig evaluation;
};

}  // namespace nlo::trainer
