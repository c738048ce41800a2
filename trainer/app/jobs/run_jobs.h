// SPDX-License-Identifier: MIT
// Runs a list of trainings for the commands that need several: at the same time or one after another, with one display.
// A job keeps its state in files (kept_training.h). If a list was interrupted or killed and is run again, each job
// finds its finished work. Also handles Ctrl-C during long work.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "trainer/app/jobs/jobs_progress.h"

namespace nlo::trainer {

enum class JobEnd {
  kDone,
  kFound,   ///< its result existed, for the same inputs
  kStopped  ///< `stop` was set; its state is saved
};

/// Arguments of a job.
struct JobContext {
  std::string name;
  int threads = 1;                             ///< threads that it may use; 0: all cores; no effect on the result
  const std::atomic<bool>* stop = nullptr;     ///< if true: save, and return kStopped
  std::function<void(double share)> progress;  ///< reports the progress of this job, in [0, 1]
};

struct Job {
  std::string name;     ///< "van_der_pol_fast, seed 2"
  double cost_s = 1.0;  ///< approximate time, used as weight in the display
  std::function<JobEnd(const JobContext& context)> work;
};

struct JobsOptions {
  int threads = 0;           ///< for all jobs together; 0: all cores
  bool side_by_side = true;  ///< false: one after another, each with all threads
  bool keep_going = false;   ///< continue after a job that fails; else no further job begins
  const std::atomic<bool>* stop = nullptr;
  JobsProgress* progress = nullptr;
};

struct JobsResult {
  std::size_t done = 0, found = 0;
  std::size_t left = 0;  ///< number of interrupted jobs and of jobs that have not begun
  std::vector<std::exception_ptr> failures;

  /// Throws the first failure, if any.
  void check() const;

  /// Returns "interrupted with 3 of 12 trainings left; to continue: COMMAND". Without a command nothing was kept,
  /// because there was no -o.
  std::string interrupted_text(const std::string& command) const;
};

/// Runs the jobs in their order. An exception of a job is its failure, unless `stop` is set: then the job counts as
/// stopped.
JobsResult run_jobs(const std::vector<Job>& jobs, const JobsOptions& options);

/// From now on the first SIGINT or SIGTERM sets the returned flag, and the run should save and stop. A second signal
/// kills the program, as usual.
const std::atomic<bool>& stop_on_interrupt();

}  // namespace nlo::trainer
