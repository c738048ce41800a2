// SPDX-License-Identifier: MIT
// What `nlo identify` reads, as a value: a plant by expressions whose parameters are to be found, the logs to find them
// from, and how. Defaults stand here and nowhere else.
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
  std::vector<double> initial_state, initial_deviation;  ///< of a segment and of the filters, n_x each
  std::vector<double> process_noise;                     ///< where the filters' tuning starts, per sqrt(s), n_x
  std::vector<std::string> fixed, positive;              ///< parameters
  Hold input_hold = Hold::kFirstOrder;
  double longest_step_s = 0.0;         ///< of RK4; 0: the sample period
  int iterations = 50;                 ///< of Levenberg and Marquardt's method, at most
  std::vector<double> from_s = {0.0};  ///< where the filters start in each log
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
