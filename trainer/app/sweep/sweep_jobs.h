// SPDX-License-Identifier: MIT
// The jobs of a plan: each trains one point with one seed into a folder of its own, and is one line for a shell.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "trainer/app/sweep/plan.h"

namespace nlo::trainer {

struct SweepJob {
  SweepPoint values;
  std::optional<unsigned long long> seed;
  std::size_t point = 0;  ///< its place among the points of the plan: jobs of one point differ in their seed alone
  /// Name of its folder: the varied settings, for people, and a hash of them. It depends on the point and the seed
  /// alone, so that a plan that grows keeps its folders.
  std::string name;

  std::vector<std::string> assignments() const;  ///< KEY=VALUE, as --set takes them
};

/// By point, then by seed.
std::vector<SweepJob> jobs_of(const SweepPlan& plan);

/// Paths for a job, relative to the directory where it runs.
struct SweepPlaces {
  std::string experiment, data, folder;  ///< for all jobs; `data` may be empty
  std::optional<int> threads;            ///< threads of each job
};

/// nlo train EXPERIMENT --set KEY=VALUE ... --seed N -o FOLDER/NAME --resume -q, quoted for a shell. Throws
/// codegen::Error where a path has a line break.
std::string job_line(const SweepJob& job, const SweepPlaces& places);

/// Part `index` of `count`, index = 0 ... count - 1: every count-th job.
struct Shard {
  std::size_t index = 0, count = 1;

  bool has(std::size_t job) const { return job % count == index; }
};

/// From "3/16". Throws codegen::Error.
Shard parse_shard(const std::string& text);

}  // namespace nlo::trainer
