// SPDX-License-Identifier: MIT
// Experiments for tests of comparisons.
#pragma once

#include <string>

#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/compare/compared_runs.h"

namespace nlo::trainer::test {

inline Experiment van_der_pol(double horizon_s = 4.0) {
  return nominal_experiment(parse_experiment(
      "name = \"test\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\nhorizon_s = " + std::to_string(horizon_s) +
          "\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, 1.0]\n[observer]\n"
          "eigenvalues = [-1.0, -2.0, -3.0]\n",
      "test.toml"));
}

}  // namespace nlo::trainer::test
