// SPDX-License-Identifier: MIT
// Results of the jobs of a sweep from their folders, evaluated as by nlo evaluate.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "trainer/app/sweep/results.h"
#include "trainer/app/sweep/sweep_jobs.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct CheckedJob {
  SweepJob job;
  Experiment experiment;  ///< the experiment of the plan with the values of the job
};

/// Returns the results by job. A job whose run is not finished has only a status. `timed`: also measures ns, the
/// smallest over some runs of the test's length, on one core of this machine in this program. Throws codegen::Error if
/// logs cannot be read or a test run overflows.
std::vector<JobResult> collect_results(const std::vector<CheckedJob>& jobs, const SweepTest& test,
                                       const SweepPlaces& places, bool timed,
                                       const std::function<void(double share, const std::string& job)>& progress);

/// Writes sweep.csv and pareto.svg into the folder of the sweep and returns the text for a terminal. Throws
/// codegen::Error if a file cannot be written or gnuplot is missing.
std::string write_collection(const std::vector<CheckedJob>& jobs, const std::vector<JobResult>& results,
                             const std::string& folder);

}  // namespace nlo::trainer
