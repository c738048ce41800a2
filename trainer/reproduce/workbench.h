// SPDX-License-Identifier: MIT
// The input of an analysis: the trained models of its experiments, the size of the tests, and a function for its
// progress.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {

/// The amount of computation.
struct Size {
  double steps = 1.0;           ///< share of the experiments' training steps
  int test_trajectories = 200;  ///< size of the test set
  int map_points = 41;          ///< initial states per axis of a map
};

constexpr Size kFullSize{};
constexpr Size kQuickSize{.steps = 0.25, .test_trajectories = 40, .map_points = 21};

/// The measurement protocol's noises in the order of the paper's tables: none, N(0, 0.5) (read as a standard
/// deviation), U(-3, 3).
std::vector<NoiseConfig> paper_noises();

/// A test of an observer.
struct Trial {
  std::string_view experiment;
  Eigen::MatrixXd initial;               ///< n_x x n initial states
  NoiseConfig noise = {};                ///< noise of the measurements
  std::vector<std::string> inputs = {};  ///< excitation of the plant, one expression over t per input; empty: none
  bool drive = true;                     ///< a driven observer may use phi(z) u (25)
};

class Workbench {
 public:
  using ModelKey = std::pair<std::string, int>;  ///< experiment, index of the seed

  Size size;
  int seeds = 3;     ///< trained models per experiment
  int threads = 0;   ///< 0: all cores
  std::string data;  ///< folder that contains the folders of logs
  std::map<std::string, Experiment, std::less<>> experiments;
  std::map<ModelKey, codegen::Model> models;
  std::function<void(double share)> progress;  ///< progress of the analysis, in [0, 1]; may throw to stop it

  const Experiment& experiment(std::string_view name) const;
  const codegen::Model& model(std::string_view experiment, int seed) const;

  /// Returns the initial states of the experiment's test set, n_x x n. They are the same for all training seeds.
  Eigen::MatrixXd test_states(std::string_view experiment, double box_scale = 1.0) const;

  /// Returns the model of a trial and seed, without phi(z) u if trial.drive is false.
  codegen::Model observer(const Trial& trial, int seed) const;

  /// Returns the plant's runs of a trial, without noise.
  Dataset truth(const Trial& trial) const;

  /// Returns the strict and the paper-like error for all seeds, over t >= from_s. The paper-like error is divided by
  /// the RMS of the state over the whole run.
  Cell measure(const Trial& trial, std::optional<double> paper = std::nullopt, double from_s = 0.0) const;
};

}  // namespace nlo::trainer::reproduction
