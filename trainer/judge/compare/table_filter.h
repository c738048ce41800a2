// SPDX-License-Identifier: MIT
// The filters of filter_table() as estimators of a plant's channels: over a recorded run, with their own
// error bounds, and in the loop that [feedback] closes.
// Tuning of a filter on runs whose truth is known: a grid over Q, R and the gate,
// then a coordinate search from its best.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/filter_table.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

/// Each knows the plant of `nominal` and the noise's nominal variance. Samples that do not arrive are stepped over.
/// Throws codegen::Error where there is no such filter, or it is not for the plant.
///   held_inputs     the u of a sample has acted since the sample before; else a ramp from there
///   with_intervals  of the normal distribution by its covariance, where it has one and the channels are
///                   the plant's own
///   tuning          that of tune_filter(); as shipped unless given
EstimatorFactory table_filter(std::string_view name, const Experiment& nominal, const NoiseConfig& noise,
                              bool held_inputs, bool with_intervals = false, const FilterTuning& tuning = {});

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise);

struct TunedFilter {
  FilterTuning tuning;
  std::string text;   ///< "Q x 100, R x 3.2, gate 3.5": differences from the filter as shipped
  double norm = 0.0;  ///< on the runs it was tuned on
  int evaluations = 0;
};

/// The tuning of `row` with the least error on `runs`. The same for any number of threads, as it uses one. `stop`:
/// gives the best so far.
TunedFilter tune_filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
                        const std::atomic<bool>* stop = nullptr);

}  // namespace nlo::trainer
