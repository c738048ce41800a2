// SPDX-License-Identifier: MIT
// The jobs of a plan: each trains one point with one seed into its own folder, and is one line for a shell.
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
  std::size_t point = 0;  ///< index among the points of the plan; jobs of one point differ only in their seed
  /// Name of its folder: the varied settings for readers, and a hash of them. It depends only on the point and the
  /// seed, so that a plan that grows keeps its folders.
  std::string name;

  std::vector<std::string> assignments() const;  ///< KEY=VALUE, for --set
};

/// Returns the jobs by point, then by seed.
std::vector<SweepJob> jobs_of(const SweepPlan& plan);

/// Paths for a job, relative to the directory where it runs.
struct SweepPlaces {
  std::string experiment, data, folder;  ///< for all jobs; `data` may be empty
  std::optional<int> threads;            ///< threads of each job
};

/// Returns the line nlo train EXPERIMENT --set KEY=VALUE ... --seed N -o FOLDER/NAME --resume -q, quoted for a shell.
/// Throws codegen::Error if a path has a line break.
std::string job_line(const SweepJob& job, const SweepPlaces& places);

/// Part `index` of `count`, index = 0 ... count - 1: every count-th job.
struct Shard {
  std::size_t index = 0, count = 1;

  bool has(std::size_t job) const { return job % count == index; }
};

/// Reads "3/16". Throws codegen::Error for another text.
Shard parse_shard(const std::string& text);

}  // namespace nlo::trainer
