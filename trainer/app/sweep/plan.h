// SPDX-License-Identifier: MIT
// A plan of many trainings: one experiment and its varied keys. A TOML file:
//   experiment = "van_der_pol"             a shipped one, or a file beside the plan
//   seeds = [1, 2, 3]                      each point is trained with each of them
//   [grid]                                 every combination of
//   inverse_map.hidden = [[16], [32, 32]]  the values of each key
//   [[zip]]                                keys that change together: one more axis of the grid
//   [[point]]                              one more point, beside the grid
//   [test]                                 how `nlo sweep collect` judges
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// One key of the experiment with one value.
struct SweepValue {
  std::string key;    ///< "training.learning_rate"
  std::string value;  ///< TOML, on one line
  std::string place;  ///< FILE:LINE
};

/// Values by key, in alphabetical order.
using SweepPoint = std::vector<SweepValue>;

/// [test]: settings of the strict test of observers of a plant. Observers of logs are tested on the test logs.
struct SweepTest {
  std::optional<NoiseConfig> noise;  ///< empty: the noise of the experiment's training
  unsigned long long seed = 1;
  int trajectories = 200;
};

struct SweepPlan {
  std::string place;       ///< the file
  std::string experiment;  ///< name or path in the plan
  std::string data;        ///< directory of logs in the plan; may be empty
  std::vector<unsigned long long> seeds;
  SweepTest test;
  std::vector<SweepPoint> points;  ///< at least one; an empty point is the experiment itself
};

/// Largest number of jobs; all of them are checked before the first line is written.
constexpr std::size_t kMostSweepJobs = 10000;

/// Parses a plan. Throws codegen::Error `FILE:LINE: reason; remedy`. Does not check whether the experiment accepts the
/// values.
SweepPlan parse_sweep_plan(std::string_view text, const std::string& filename);
SweepPlan read_sweep_plan(const std::string& path);

}  // namespace nlo::trainer
