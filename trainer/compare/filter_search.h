// SPDX-License-Identifier: MIT
// Tuning of a filter on runs whose truth is known: a grid over Q, R and the gate,
// then a coordinate search from its best.
#pragma once

#include <atomic>
#include <string>

#include "trainer/compare/compared_runs.h"
#include "trainer/compare/filter_table.h"

namespace nlo::trainer {

struct TunedFilter {
  FilterTuning tuning;
  std::string text;   ///< "Q x 100, R x 3.2, gate 3.5": what differs from the filter as shipped
  double norm = 0.0;  ///< on the runs it was tuned on
  int evaluations = 0;
};

/// The tuning of `row` with the least error on `runs`. The same for any number of threads, as it uses one. `stop`:
/// gives the best so far.
TunedFilter tune_filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
                        const std::atomic<bool>* stop = nullptr);

}  // namespace nlo::trainer
