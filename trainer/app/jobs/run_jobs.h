// SPDX-License-Identifier: MIT
// A list of trainings, for every command that has one: several at once or one by one, with one display. A job keeps its
// own state in files (kept_training.h); a list that was stopped or killed is run again,
// and each job finds its finished work.
// Ctrl-C while something long runs.
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
  kFound,   ///< its result was there, of the same inputs: nothing was to be done
  kStopped  ///< `stop` was set; its state is saved
};

/// Arguments of a job.
struct JobContext {
  std::string name;
  int threads = 1;                          ///< threads that it may use; 0: all cores; the result does not depend on it
  const std::atomic<bool>* stop = nullptr;  ///< when true: save, and end as stopped
  std::function<void(double share)> progress;  ///< reports the progress of this job, in [0, 1]
};

struct Job {
  std::string name;     ///< "van_der_pol_fast, seed 2"
  double cost_s = 1.0;  ///< roughly: its weight in the display
  std::function<JobEnd(const JobContext& context)> work;
};

struct JobsOptions {
  int threads = 0;           ///< for all jobs together; 0: all cores
  bool side_by_side = true;  ///< else one by one, each with all threads
  bool keep_going = false;   ///< past a job that fails; else none is begun after it
  const std::atomic<bool>* stop = nullptr;
  JobsProgress* progress = nullptr;
};

struct JobsResult {
  std::size_t done = 0, found = 0;
  std::size_t left = 0;  ///< stopped, or not begun
  std::vector<std::exception_ptr> failures;

  /// Throws the first failure, if there is one.
  void check() const;

  /// "interrupted with 3 of 12 trainings left; this goes on: COMMAND". Without a command nothing was kept,
  /// for want of -o.
  std::string interrupted_text(const std::string& command) const;
};

/// Runs them in their order. What a job throws is its failure, unless `stop` is set: then the job counts as stopped.
JobsResult run_jobs(const std::vector<Job>& jobs, const JobsOptions& options);

/// From now on the first SIGINT or SIGTERM sets the flag returned, and the run is to save and stop; a second one kills,
/// as everywhere.
const std::atomic<bool>& stop_on_interrupt();

}  // namespace nlo::trainer
