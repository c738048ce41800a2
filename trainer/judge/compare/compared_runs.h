// SPDX-License-Identifier: MIT
// Runs of a plant under one condition, with the readings of its sensors, and the error of an estimator on them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/filters/lane_plant.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"

namespace nlo::trainer {

struct ComparedRuns {
  Dataset set;                           ///< all runs, seed by seed, as channels: clean outputs and true states
  LaneRuns measured;                     ///< the plant's own outputs, in the format for filters
  std::vector<Eigen::MatrixXd> outputs;  ///< outputs of each run, n_y x N, in the format for observers
  PlantChannels channels;
  Eigen::Index plant_states = 0;  ///< n_x of the plant, before the conversion to channels
  Eigen::VectorXd state_scale;    ///< scale of the channels in norms: 1, or their deviations if units differ
};

/// Makes `count` runs for each of the seeds first_seed, ... Initial states follow from initial_state_seed(seed,
/// stream), the noise from the seed and the run's number in its set. For the stream kTest these are the runs of `nlo
/// evaluate --seed`.
ComparedRuns compared_runs(const Experiment& nominal, const Condition& condition, SeedStream stream,
                           std::uint64_t first_seed, int seeds, int count);

/// Returns test set number `index` of `count` runs.
Dataset set_of(const ComparedRuns& runs, int index, int count);

/// Returns estimates of the channels in each run, n x N, by a filter that steps all runs side by side.
std::vector<Eigen::MatrixXd> lane_estimates(LaneFilter& filter, const ComparedRuns& runs);

/// Returns the runs with `runs.outputs` as readings, in the format for filters.
LaneRuns lanes_of(const ComparedRuns& runs, bool held_inputs);

/// Returns the mean of |x - x_hat|^2 over the samples of each lane. `lanes` has the lanes of `runs` one or more times.
Eigen::ArrayXd squared_errors(LaneFilter& filter, const LaneRuns& lanes, const ComparedRuns& runs);

/// Returns the mean squared error of the estimates of run `index` (n x N), from sample `first` on.
double squared_error(const ComparedRuns& runs, std::size_t index, const Eigen::MatrixXd& estimates,
                     Eigen::Index first = 0);

}  // namespace nlo::trainer
