// SPDX-License-Identifier: MIT
// Results of the jobs of a plan: a row for each job, a line for each point over its seeds, and the points that no other
// point beats in both error and cost.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "trainer/app/sweep/sweep_jobs.h"

namespace nlo::trainer {

enum class JobStatus {
  kDone,
  kFailed,      ///< the training diverged or did not improve its start; a repetition would fail again
  kUnfinished,  ///< begun; run its line again
  kMissing,     ///< not begun
  kOther        ///< its folder holds a training of another experiment or plan
};

std::string to_text(JobStatus status);

/// Cost of an observer as a C++ header in float.
struct JobCost {
  Eigen::Index multiply_adds = 0;  ///< multiply-adds of a step and an estimate
  Eigen::Index flash_bytes = 0;    ///< flash of constants
  std::optional<double> ns = {};   ///< time of a step and an estimate on this machine, if measured
};

/// Returns one of the costs: an axis of the figure.
using CostOf = std::optional<double> (*)(const JobCost& cost);
std::optional<double> multiply_adds_of(const JobCost& cost);
std::optional<double> flash_bytes_of(const JobCost& cost);
std::optional<double> ns_of(const JobCost& cost);

struct JobResult {
  JobStatus status = JobStatus::kMissing;
  std::string message = {};                     ///< reason for the failure
  std::optional<double> validation_error = {};  ///< error that chose the model, under the noise of the training
  std::optional<double> error = {};             ///< error on test runs, or on test logs
  std::optional<JobCost> cost = {};
};

/// A point with all its seeds.
struct PointResult {
  std::string title;  ///< "hidden=[16] learning_rate=0.001"
  std::size_t jobs = 0, done = 0;
  std::optional<double> error, standard_error;  ///< mean over the seeds if all are done; standard error of two or more
  std::optional<JobCost> cost;                  ///< largest cost over the seeds
  bool best_for_multiply_adds = false, best_for_flash = false, best_for_ns = false;  ///< on the Pareto front
};

/// Combines the results of the jobs, in the order of `jobs`. Points with unfinished jobs have no error, because a mean
/// over the finished ones would be too good.
std::vector<PointResult> point_results(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results);

/// Marks the points that are on the Pareto fronts.
void mark_fronts(std::vector<PointResult>& points);

/// Writes job,KEY...,seed,status,validation_error,error,multiply_adds,flash_bytes,ns: a row for each job. The same jobs
/// give the same bytes, however often they were interrupted, except ns, which depends on the machine and is empty
/// unless measured.
std::string sweep_csv(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results);

/// Returns tables and findings for a terminal.
std::string sweep_text(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results,
                       const std::vector<PointResult>& points);

}  // namespace nlo::trainer
