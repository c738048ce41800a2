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
  kFailed,      ///< the training diverged or got nowhere, and would again
  kUnfinished,  ///< begun: run its line again
  kMissing,     ///< not begun
  kOther        ///< its folder holds a training of another experiment or plan
};

std::string to_text(JobStatus status);

/// The cost of an observer as a C++ header in float.
struct JobCost {
  Eigen::Index multiply_adds = 0;  ///< multiply-adds of a step and an estimate
  Eigen::Index flash_bytes = 0;    ///< flash of constants
  std::optional<double> ns = {};   ///< time of a step and an estimate on this machine, if measured
};

/// One of the costs: an axis of the picture.
using CostOf = std::optional<double> (*)(const JobCost& cost);
std::optional<double> multiply_adds_of(const JobCost& cost);
std::optional<double> flash_bytes_of(const JobCost& cost);
std::optional<double> ns_of(const JobCost& cost);

struct JobResult {
  JobStatus status = JobStatus::kMissing;
  std::string message = {};                     ///< why it failed
  std::optional<double> validation_error = {};  ///< error that chose the model, under the training's noise
  std::optional<double> error = {};             ///< on test runs, or on test logs
  std::optional<JobCost> cost = {};
};

/// A point over its seeds.
struct PointResult {
  std::string title;  ///< "hidden=[16] learning_rate=0.001"
  std::size_t jobs = 0, done = 0;
  std::optional<double> error, standard_error;  ///< mean over the seeds, only when all are done; of two or more
  std::optional<JobCost> cost;                  ///< the largest over the seeds
  bool best_for_multiply_adds = false, best_for_flash = false, best_for_ns = false;  ///< on the Pareto front
};

/// `results` by job. Points whose jobs are not all done have no error: a mean of the rest would flatter.
std::vector<PointResult> point_results(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results);

/// Sets which points are on the Pareto fronts.
void mark_fronts(std::vector<PointResult>& points);

/// job,KEY...,seed,status,validation_error,error,multiply_adds,flash_bytes,ns: a row for each job. The same jobs give
/// the same bytes, however often they were interrupted; only ns, empty unless it was measured,
/// is of this machine and hour.
std::string sweep_csv(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results);

/// Tables and findings for a terminal.
std::string sweep_text(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results,
                       const std::vector<PointResult>& points);

}  // namespace nlo::trainer
