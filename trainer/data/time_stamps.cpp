// SPDX-License-Identifier: MIT
#include "trainer/data/time_stamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/base/quantile.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<double> steps_of(const std::vector<VectorXd>& times_s) {
  Index count = 0;
  for (const VectorXd& time_s : times_s) count += time_s.size();
  std::vector<double> steps;
  steps.reserve(static_cast<std::size_t>(count));
  for (const VectorXd& time_s : times_s)
    for (Index k = 1; k < time_s.size(); ++k) steps.push_back(time_s[k] - time_s[k - 1]);
  return steps;
}

/// Returns the steps in periods: integers of at least one.
VectorXd counts_of(const VectorXd& steps, double period_s) {
  VectorXd counts(steps.size() + 1);
  counts[0] = 0.0;
  for (Index k = 0; k < steps.size(); ++k) counts[k + 1] = counts[k] + std::max(1.0, std::round(steps[k] / period_s));
  return counts;
}

/// Returns the mean of all steps that miss no sample. The median of rounded steps may be wrong by the rounding (2.5 ms
/// printed in ms: 2 or 3).
double mean_plain_step(const VectorXd& steps, double resolution_s) {
  std::vector<double> sorted(steps.begin(), steps.end());
  std::sort(sorted.begin(), sorted.end());
  const double longest = 1.5 * value_at_rank(sorted, 0.5) + 0.5 * resolution_s;
  double sum = 0.0, count = 0.0;
  for (const double step : sorted) {
    if (step > longest) break;
    sum += step;
    ++count;
  }
  return sum / count;
}

/// Returns true if a is a multiple of b up to the rounding of a: its last bit, and some more from its computation.
bool is_multiple(double a, double b) {
  const double ratio = a / b;
  const double slack = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(ratio);
  return slack < 0.05 && std::abs(ratio - std::round(ratio)) <= slack + 1e-9;
}

}  // namespace

TimeGrid fit_time_grid(const VectorXd& time_s, double resolution_s) {
  const Index n = time_s.size();
  TimeGrid grid;
  {
    const VectorXd steps = time_s.tail(n - 1) - time_s.head(n - 1);
    grid.counts = counts_of(steps, mean_plain_step(steps, resolution_s));
  }
  grid.complete = grid.counts[n - 1] == static_cast<double>(n - 1);
  VectorXd rest = time_s.array() - time_s.mean();
  const VectorXd count = grid.counts.array() - grid.counts.mean();
  grid.period_s = rest.dot(count) / count.squaredNorm();
  rest -= grid.period_s * count;
  grid.deviation_s = rest.cwiseAbs().maxCoeff();
  // Rounding spreads the residual over one resolution. If the rounding is not random (for example 7.5 ms printed in
  // ms), it tilts the fitted line by up to 1.5 resolutions over the log. Stamps coarser than half a period cannot show
  // a missing sample.
  grid.rounded = resolution_s > 0.0 && resolution_s <= 0.5 * grid.period_s &&
                 rest.maxCoeff() - rest.minCoeff() <= 1.5 * resolution_s;
  grid.regular = grid.rounded || grid.deviation_s <= kRegularJitter * grid.period_s;
  return grid;
}

bool has_period(const TimeGrid& grid, double period_s) {
  const double uncertainty = 2.0 * grid.deviation_s / grid.counts[grid.counts.size() - 1];
  return std::abs(grid.period_s - period_s) <= kSamePeriod * period_s + uncertainty;
}

double stamp_resolution(const VectorXd& stamps) {
  for (int digits = -6; digits <= 9; ++digits) {
    const double unit = std::pow(10.0, -digits);
    if (std::all_of(stamps.begin(), stamps.end(), [unit](double t) { return is_multiple(t, unit); })) return unit;
  }
  return 0.0;
}

TimeStampReport report_time_stamps(const std::string& file, const std::vector<VectorXd>& times_s, double nominal_s) {
  TimeStampReport report;
  report.file = file;
  report.runs = times_s.size();
  for (const VectorXd& time_s : times_s) {
    report.samples += time_s.size();
    report.duration_s += time_s[time_s.size() - 1] - time_s[0];
  }
  std::vector<double> steps = steps_of(times_s);
  report.median_s = value_at_rank_of(steps, 0.5);
  report.p01_s = value_at_rank_of(steps, 0.01);
  report.p99_s = value_at_rank_of(steps, 0.99);
  report.max_s = *std::max_element(steps.begin(), steps.end());
  report.gaps =
      static_cast<int>(std::count_if(steps.begin(), steps.end(), [&](double h) { return h > 1.5 * nominal_s; }));
  return report;
}

std::string named(const TimeStampReport& report) {
  return report.runs == 1 ? report.file : fmt::format("{} ({} runs)", report.file, report.runs);
}

double median_step(const std::vector<VectorXd>& times_s) {
  std::vector<double> steps = steps_of(times_s);
  return value_at_rank_of(steps, 0.5);
}

}  // namespace nlo::trainer
