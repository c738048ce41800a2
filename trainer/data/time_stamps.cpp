// SPDX-License-Identifier: MIT
#include "trainer/data/time_stamps.h"

#include <algorithm>
#include <cmath>

namespace nlo::trainer {
namespace {

void append_steps(const Eigen::VectorXd& time_s, std::vector<double>& steps) {
  for (Eigen::Index k = 1; k < time_s.size(); ++k) steps.push_back(time_s[k] - time_s[k - 1]);
}

/// Nearest rank on a sorted, non-empty list; q in [0, 1].
double quantile(const std::vector<double>& sorted, double q) {
  return sorted[static_cast<std::size_t>(std::lround(q * static_cast<double>(sorted.size() - 1)))];
}

}  // namespace

TimeStampReport report_time_stamps(const std::string& file, const Eigen::VectorXd& time_s, double nominal_s) {
  std::vector<double> steps;
  append_steps(time_s, steps);
  std::sort(steps.begin(), steps.end());
  TimeStampReport report;
  report.file = file;
  report.samples = time_s.size();
  report.duration_s = time_s[time_s.size() - 1] - time_s[0];
  report.median_s = quantile(steps, 0.5);
  report.p01_s = quantile(steps, 0.01);
  report.p99_s = quantile(steps, 0.99);
  report.max_s = steps.back();
  report.gaps =
      static_cast<int>(std::count_if(steps.begin(), steps.end(), [&](double h) { return h > 1.5 * nominal_s; }));
  return report;
}

double median_step(const std::vector<Eigen::VectorXd>& times_s) {
  std::vector<double> steps;
  for (const Eigen::VectorXd& time_s : times_s) append_steps(time_s, steps);
  std::sort(steps.begin(), steps.end());
  return quantile(steps, 0.5);
}

}  // namespace nlo::trainer
