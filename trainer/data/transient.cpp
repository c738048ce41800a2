// SPDX-License-Identifier: MIT
#include "trainer/data/transient.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/base/error.h"

namespace nlo::trainer {

double decay_rate(const ObserverConfig& observer) {
  double slowest = std::numeric_limits<double>::infinity();
  for (const double lambda : observer.eigenvalues) slowest = std::min(slowest, std::abs(lambda));
  for (const auto& pair : observer.pairs) slowest = std::min(slowest, std::abs(pair[0]));
  return std::isfinite(slowest) ? slowest : 0.0;
}

double transient_time_s(const ObserverConfig& observer, double factor) {
  const double rate = decay_rate(observer);
  return rate > 0.0 ? factor / rate : std::numeric_limits<double>::infinity();
}

void drop_transient(Dataset& dataset, double transient_s) {
  const double rounding = 1e-9 * dataset.sample_period_s;  // a sample at t_c itself counts
  for (Trajectory& run : dataset.trajectories) {
    if (run.samples() == 0) continue;
    const Eigen::ArrayXd since_start = run.time_s.array() - run.time_s(0);
    const auto dropped = since_start < transient_s - rounding;
    run.weight = dropped.select(0.0, run.weight);
    run.first_estimate = std::max(run.first_estimate, static_cast<Eigen::Index>(dropped.count()));
    if (run.weight.maxCoeff() > 0.0) continue;
    throw codegen::Error(
        fmt::format("{}: transient = \"drop\" leaves no sample, because the run lasts {:.4g} s and the transient "
                    "{:.4g} s; use faster eigenvalues, a smaller transient_factor or longer runs",
                    run.source, since_start.maxCoeff(), transient_s));
  }
}

}  // namespace nlo::trainer
