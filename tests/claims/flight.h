// SPDX-License-Identifier: MIT
// Flies an observer: exports it, compiles it with the user's compiler, and steps it over whole runs, including masked
// samples.
#pragma once

#include <map>
#include <string>

#include "tests/claims/ledger.h"

namespace nlo::claims {

/// Paths of programs and of the folder to work in.
struct Tools {
  std::string nlo, compiler, runtime, source;  ///< `runtime`: folder of nlo/*.h; `source`: root of this repository
  std::string work;
};

/// Runs a command with its stderr in LOG and returns its stdout. If the command fails, throws std::runtime_error with
/// the end of LOG.
std::string output_of(const std::string& command, const std::string& log);

/// Returns the figures of a flight of DIRECTORY/model.json over the test logs in `data`, or over the first eight test
/// runs of the plant:
///   in_domain            share of samples with in_domain()
///   first_in_domain      share of runs whose first sample has in_domain()
///   first_in_range       share of runs whose first estimate lies within the range of the truth
///   ok                   share of samples with StepStatus::kOk
///   rmse STATE           over the samples that are not masked, in the unit of the state
///   parity STATE         largest difference from the estimates of `nlo evaluate`, divided by the RMS of the state
std::map<std::string, double> fly(const Experiment& experiment, const std::string& directory, const std::string& data,
                                  const Tools& tools);

}  // namespace nlo::claims
