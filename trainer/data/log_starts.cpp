// SPDX-License-Identifier: MIT
#include "trainer/data/log_starts.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

Trajectory tail_of(const Trajectory& run, Eigen::Index first, double start_s) {
  Trajectory tail = run.from(first);
  if (first == 0) return tail;
  const std::string behind = fmt::format(" from {} s", shortest_text(start_s));
  tail.source += behind;
  if (!tail.log.empty()) tail.log += behind;
  return tail;
}

}  // namespace

Dataset started_at(const Dataset& logs, const std::vector<double>& from_s) {
  Dataset result = logs;
  result.trajectories.clear();
  for (const double start_s : from_s) {
    if (!(start_s >= 0.0))
      throw codegen::Error(
          fmt::format("--from {}: a start lies 0 s or more behind a log's first sample", shortest_text(start_s)));
    bool any = false;
    double longest_s = 0.0;
    for (const Trajectory& run : logs.trajectories) {
      const double* end = run.time_s.data() + run.samples();
      // A start that is a sample but for the rounding of stamps is that sample.
      const double at_s = run.time_s(0) + start_s - 1e-6 * logs.sample_period_s;
      const Eigen::Index first = std::lower_bound(run.time_s.data(), end, at_s) - run.time_s.data();
      longest_s = std::max(longest_s, run.time_s(run.samples() - 1) - run.time_s(0));
      if (run.samples() - first < 2) continue;
      result.trajectories.push_back(tail_of(run, first, start_s));
      any = true;
    }
    if (!any)
      throw codegen::Error(fmt::format("--from {}: the longest log ends after {} s; start before that",
                                       shortest_text(start_s), shortest_text(longest_s)));
  }
  return result;
}

}  // namespace nlo::trainer
