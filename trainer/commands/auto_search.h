// SPDX-License-Identifier: MIT
// nlo train --auto: many experiments about a given one by successive halving, on one set of data, judged on validation
// runs that neither their training nor any test has seen.
#pragma once

#include <cstdint>
#include <string>

#include "trainer/commands/training_data.h"
#include "trainer/config/experiment.h"
#include "trainer/sweep/search_record.h"

namespace nlo::trainer {

struct SearchBudget {
  double minutes = 10.0;
  std::int64_t multiply_adds = 0, flash_bytes = 0;  ///< of the export in float; 0: no limit
};

/// An experiment whose logs are split for a search, and what comes of them.
struct SearchTask {
  Experiment experiment;  ///< as it stands; with logs: those held out are its validation_files
  RunData data;           ///< of it
  std::string held_out;   ///< logs that were taken from training to choose by; empty: none
};

/// Where the experiment names no validation_files, every fourth of its training logs is held out. Throws codegen::Error
/// where there is but one, and for what --auto does not search: rounds of [feedback].
SearchTask search_task(Experiment experiment, const std::string& data_directory);

/// Runs the search in `directory`, or goes on with the one that was interrupted there: killed at any moment and run again
/// it tries the same. Throws RunFailure when it was interrupted or nothing could be trained, codegen::Error where the
/// directory holds another search, or where nothing keeps to the budget.
SearchRecord run_search(const SearchTask& task, const SearchBudget& budget, const std::string& directory, bool resume,
                        bool quiet);

}  // namespace nlo::trainer
