// SPDX-License-Identifier: MIT
// What an analysis works with: the trained models of its experiments, the size of the tests, and a way to say how far
// it is.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/model.h"
#include "trainer/config.h"
#include "trainer/noise.h"
#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {

/// How much is computed.
struct Size {
  double steps = 1.0;           ///< share of the experiments' training steps
  int test_trajectories = 200;  ///< of the protocol's test set
  int map_points = 41;          ///< initial states per axis of a map
};

constexpr Size kFullSize{};
constexpr Size kQuickSize{.steps = 0.25, .test_trajectories = 40, .map_points = 21};

/// The measurement protocol's noises in the order of the paper's tables: none, N(0, 0.5) (read as a standard
/// deviation), U(-3, 3).
std::vector<NoiseConfig> paper_noises();

class Workbench {
 public:
  using ModelKey = std::pair<std::string, int>;  ///< experiment, index of the seed

  Size size;
  int seeds = 3;    ///< trained models per experiment
  int threads = 0;  ///< 0: all cores
  std::map<std::string, Experiment, std::less<>> experiments;
  std::map<ModelKey, codegen::Model> models;
  std::function<void(double share)> progress;  ///< of the analysis, in [0, 1]; may throw to stop it

  const Experiment& experiment(std::string_view name) const;
  const codegen::Model& model(std::string_view experiment, int seed) const;

  /// n_x x n initial states of the experiment's test set: the same for all training seeds.
  Eigen::MatrixXd test_states(std::string_view experiment, double box_scale = 1.0) const;

  /// Both readings from the same initial states, for all seeds, over t >= from_s; the paper-like one is divided by the
  /// RMS of the state over the whole run.
  Cell measure(std::string_view experiment, const Eigen::MatrixXd& initial, const NoiseConfig& noise,
               std::optional<double> paper = std::nullopt, double from_s = 0.0) const;
};

}  // namespace nlo::trainer::reproduction
