// SPDX-License-Identifier: MIT
// The filters for comparison, one row each: their factory, their tuned values, and the cost of a step.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/judge/filters/lane_plant.h"
#include "trainer/judge/filters/sigma_point_filter.h"
#include "trainer/judge/filters/step_cost.h"

namespace nlo::trainer {

/// The knowledge of every filter about a plant under one condition: its nominal parameters and process noise, the
/// initial states in training, and the nominal variance of the sensors' noise. Two threads must not share it.
struct FilterContext {
  PlantConfig config;  ///< nominal
  LanePlant plant;
  std::vector<std::string> states;            ///< their names
  FilterKnowledge knowledge;                  ///< knowledge about the n_x states
  std::vector<std::string> joint_parameters;  ///< parameters that the conditions change
  Eigen::MatrixXd initial;                    ///< some initial states, n_x x count
  double sample_period_s = 0.0;
  Eigen::Index inputs = 0;  ///< number of inputs that excite the plant
};

/// Number of samples in a moving horizon.
inline constexpr Eigen::Index kHorizonSamples = 25;

/// A tuned number of a filter: a factor for one of its noises.
struct TunedFactor {
  std::string name;  ///< "Q", "Q of x1"
  std::function<void(FilterTuning& tuning, double factor)> set;
  /// Start values of the search: powers of ten, combined with those of the other factors.
  std::vector<double> decades = {0.0};
};

struct FilterRow {
  std::string_view name;                                              ///< name in estimator_words.h
  std::vector<TunedFactor> (*factors)(const FilterContext& context);  ///< tuned factors without the gate
  bool has_gate;
  int most_sweeps;  ///< most sweeps of the tuning over its factors, after the grid of starts; fewer if a step takes
                    ///< long
  /// Returns the reason why a plant cannot have this filter; empty: it can.
  std::string (*unfit)(const FilterContext& context);
  std::unique_ptr<LaneFilter> (*make)(const FilterContext& context, const std::vector<FilterTuning>& tunings,
                                      Eigen::Index lanes);
  /// Returns the cost per sample of one run.
  StepCost (*cost)(const FilterContext& context, const PlantCost& plant);
  /// Returns the number of values in its state between samples.
  Eigen::Index (*state)(const FilterContext& context);
};

/// Returns the filters in the order of the tables.
std::span<const FilterRow> filter_table();

/// Returns null if there is no filter of this name.
const FilterRow* find_filter(std::string_view name);

/// Returns the names for --against.
std::vector<std::string> filter_names();

FilterContext filter_context(const Experiment& nominal, const NoiseConfig& noise,
                             const std::vector<std::string>& joint_parameters);

}  // namespace nlo::trainer
