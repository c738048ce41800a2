// SPDX-License-Identifier: MIT
// Turns the filters of filter_table() into estimators of a plant's channels, for a recorded run (with their own error
// bounds) and for the loop of [feedback]. Tunes a filter on runs with a known truth: a grid over Q, R and the gate,
// then a coordinate search from its best point.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/filter_table.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

/// Makes a filter that knows the plant of `nominal` and the nominal variance of the noise. It steps over samples that
/// do not arrive. Throws codegen::Error if there is no such filter, or if the plant cannot have it.
///   held_inputs     the u of a sample has acted since the last sample; else it is a ramp
///   with_intervals  adds intervals of the normal distribution by its covariance, if it has one and the channels are
///   those of the plant
///   tuning          result of tune_filter(); without it the filter is as shipped
EstimatorFactory table_filter(std::string_view name, const Experiment& nominal, const NoiseConfig& noise,
                              bool held_inputs, bool with_intervals = false, const FilterTuning& tuning = {});

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise);

struct TunedFilter {
  FilterTuning tuning;
  std::string text;   ///< differences from the filter as shipped: "Q x 100, R x 3.2, gate 3.5"
  double norm = 0.0;  ///< error on the runs of the tuning
  int evaluations = 0;
};

/// Returns the tuning of `row` with the smallest error on `runs`. It uses one thread, so the result does not depend on
/// the number of threads. `stop`: returns the best tuning so far.
TunedFilter tune_filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
                        const std::atomic<bool>* stop = nullptr);

}  // namespace nlo::trainer
