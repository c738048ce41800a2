// SPDX-License-Identifier: MIT
// nlo train --auto: many experiments about a given one by successive halving, on one set of data, judged on validation
// runs that neither their training nor any test has seen.
#pragma once

#include <cstdint>
#include <string>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/search_task.h"
#include "trainer/app/sweep/search_record.h"

namespace nlo::trainer {

struct SearchBudget {
  double minutes = 10.0;
  std::int64_t multiply_adds = 0, flash_bytes = 0;  ///< limits of the export in float; 0: no limit
};

/// The time does not suffice for a training that is worth its name. Going on would change nothing.
struct TooLittleTime : RunFailure {
  using RunFailure::RunFailure;
};

/// Runs the search in `directory`, which the caller has taken (run_folder.h), or goes on with the one that was
/// interrupted there: killed at any moment and run again it tries the same. Throws RunFailure when it was interrupted
/// or nothing could be trained, TooLittleTime (before anything is written, unless trainings turn out slower than they
/// began) where the result would be trained for less than kLeastShareOfSteps, codegen::Error where the directory
/// holds another search, or where nothing keeps to the budget.
SearchRecord run_search(const SearchTask& task, const SearchBudget& budget, const std::string& directory, bool resume,
                        bool quiet);

}  // namespace nlo::trainer
