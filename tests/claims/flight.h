// SPDX-License-Identifier: MIT
// An observer as it flies: exported, compiled by the user's compiler, and stepped over whole runs from their first
// sample, masked or not.
#pragma once

#include <map>
#include <string>

#include "tests/claims/ledger.h"

namespace nlo::claims {

/// Paths of programs and of the folder to work in.
struct Tools {
  std::string nlo, compiler, runtime, source;  ///< `runtime`: folder of nlo/*.h; `source`: of this repository
  std::string work;
};

/// Runs a command, what it says in LOG; returns what it printed on stdout. Throws std::runtime_error with the end of
/// LOG when it fails.
std::string output_of(const std::string& command, const std::string& log);

/// Figures of the flight of DIRECTORY/model.json, over the test logs in `data`, or over the first eight runs of the
/// plant's test set:
///   in_domain            share of samples with in_domain()
///   first_in_domain      share of runs whose first sample has it
///   first_in_range       share of runs whose first estimate lies within the range of the truth
///   ok                   share of samples with StepStatus::kOk
///   rmse STATE           over the samples whose truth counts, in the state's unit
///   parity STATE         largest difference from the estimates that `nlo evaluate` judges, over the RMS of the state
std::map<std::string, double> fly(const Experiment& experiment, const std::string& directory, const std::string& data,
                                  const Tools& tools);

}  // namespace nlo::claims
