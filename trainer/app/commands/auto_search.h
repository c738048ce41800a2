// SPDX-License-Identifier: MIT
// nlo train --auto: tries many variants of a given experiment by successive halving, on one set of data, and compares
// them on validation runs that neither their training nor any test uses.
#pragma once

#include <cstdint>
#include <string>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/search_task.h"
#include "trainer/app/sweep/search_record.h"

namespace nlo::trainer {

struct SearchBudget {
  double minutes = 10.0;
  std::int64_t multiply_adds = 0, flash_bytes = 0;  ///< limits for the export in float; 0: no limit
};

/// The time is too short for a useful training. More of the same search would not help.
struct TooLittleTime : RunFailure {
  using RunFailure::RunFailure;
};

/// Runs the search in `directory`, which the caller has locked (run_folder.h), or continues the one that was
/// interrupted there. If it is killed at any moment and run again, it tries the same candidates. Throws RunFailure if
/// it was interrupted or nothing could be trained; TooLittleTime if the result would be trained for less than
/// kLeastShareOfSteps (before anything is written, unless the trainings become slower later); codegen::Error if the
/// directory holds another search, or if no candidate keeps to the budget.
SearchRecord run_search(const SearchTask& task, const SearchBudget& budget, const std::string& directory, bool resume,
                        bool quiet);

}  // namespace nlo::trainer
