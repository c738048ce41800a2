// SPDX-License-Identifier: MIT
// The file of `nlo identify` as a value: a plant given by expressions with unknown parameters, the logs, and the
// method. Defaults are only here.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// [identify]
struct IdentifyConfig {
  double segment_s = 1.0;                                ///< length of the segments that are simulated
  int most_samples = 40000;                              ///< with more samples, every n-th segment is used
  std::vector<std::pair<std::string, double>> noise;     ///< standard deviation of each fitted output or state, by name
  std::vector<double> initial_state, initial_deviation;  ///< start of a segment and of the filters, n_x each
  std::vector<double> process_noise;                     ///< initial value of the filters' tuning, per sqrt(s), n_x
  std::vector<std::string> fixed, positive;              ///< names of parameters
  Hold input_hold = Hold::kFirstOrder;
  double longest_step_s = 0.0;         ///< longest step of RK4; 0: the sample period
  int iterations = 50;                 ///< most iterations of Levenberg and Marquardt's method
  std::vector<double> from_s = {0.0};  ///< times at which the filters start in each log
};

struct Identification {
  std::string name;
  int threads = 0;    ///< 0: all cores. The result does not depend on it.
  PlantConfig plant;  ///< given by expressions; outputs may use the inputs; the range of a parameter bounds it
  LogConfig log;      ///< columns with the names of the plant
  IdentifyConfig identify;
  EvaluationConfig evaluation;
};

}  // namespace nlo::trainer
