// SPDX-License-Identifier: MIT
#include "trainer/data/log_clock.h"

#include <fmt/format.h>

#include "codegen/base/error.h"
#include "trainer/data/log_report.h"
#include "trainer/data/log_stamps.h"
#include "trainer/data/time_stamps.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::VectorXd;

std::string set_period(double period_s) {
  return fmt::format(
      "if this is the period in flight, set [log] sample_period_s = {:.6g}, or 0 to derive it from the stamps",
      period_s);
}

}  // namespace

void check_period(const LogFile& log, const LogRun& run, double nominal_s, std::vector<std::string>& notes) {
  const double median_s = median_step({run.time_s}), ratio = median_s / nominal_s;
  if (ratio > 100.0 || ratio < 0.01)
    throw Error(
        fmt::format("{}: the median step is {:.6g} s, but the nominal sample period is {:.6g} s: is the unit of the "
                    "time column s, ms, us or ns? set unit at the column with role = \"time\"",
                    log.path, median_s, nominal_s));
  if (run.grid.regular && !has_period(run.grid, nominal_s))
    note_once(notes,
              fmt::format("{}: its stamps have the period {:.6g} s, but the nominal sample period is {:.6g} s: {}",
                          log.name, run.grid.period_s, nominal_s, set_period(run.grid.period_s)));
  else if (!run.grid.regular && (ratio > 1.05 || ratio < 0.95))
    note_once(notes, fmt::format("{}: the median step is {:.6g} s, but the nominal sample period is {:.6g} s: {}",
                                 log.name, median_s, nominal_s, set_period(median_s)));
}

double nominal_period(const LogConfig& config, const LogRuns& runs) {
  if (config.sample_period_s > 0.0) return config.sample_period_s;
  double duration_s = 0.0, steps = 0.0;
  std::vector<VectorXd> times;
  for (const auto& file : runs)
    for (const LogRun& run : file) {
      const double count = run.grid.counts[run.rows - 1];
      duration_s += count * run.grid.period_s;
      steps += count;
      times.push_back(run.time_s);
    }
  const double mean_s = duration_s / steps;
  for (const auto& file : runs)
    for (const LogRun& run : file)
      if (!run.grid.regular || !has_period(run.grid, mean_s)) return median_step(times);
  return mean_s;
}

LogRuns split_logs(const LogConfig& config, const std::vector<LogFile>& logs, std::vector<std::string>& notes) {
  std::vector<VectorXd> times;
  for (const LogFile& log : logs) times.push_back(log.time_s);
  const double about_s = config.sample_period_s > 0.0 ? config.sample_period_s : median_step(times);
  LogRuns runs;
  for (const LogFile& log : logs)
    runs.push_back(split_at_gaps(log, config.max_gap_s > 0.0 ? config.max_gap_s : kGapPeriods * about_s, notes));
  return runs;
}

}  // namespace nlo::trainer
