// SPDX-License-Identifier: MIT
#include "trainer/data/log_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/csv.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

void read_time(const CsvTable& table, const LogSchema& schema, double sample_period_s, LogFile& log) {
  if (table.rows() < 2)
    throw Error(fmt::format("{}: one data row: expected a log of at least two samples", table.file()));
  if (schema.time_heading.empty()) {
    log.time_s = VectorXd::LinSpaced(table.rows(), 0.0, sample_period_s * static_cast<double>(table.rows() - 1));
    return;
  }
  const VectorXd stamps = table.column(schema.time_heading);
  for (Index k = 1; k < stamps.size(); ++k)
    if (!(stamps[k] > stamps[k - 1]))
      throw Error(fmt::format("{}:{}:{}: time does not increase: {} follows {}: sort the rows and drop repeated ones",
                              table.file(), table.line(k), schema.time_heading, stamps[k], stamps[k - 1]));
  log.time_s = (stamps.array() - stamps[0]) * schema.time_unit_s;
  log.resolution_s = stamp_resolution(stamps) * schema.time_unit_s;
}

}  // namespace

std::vector<std::string> listed_headings(const LogSchema& schema) {
  std::vector<std::string> headings;
  for (const auto* columns : {&schema.outputs, &schema.states, &schema.inputs})
    for (const LogColumn& column : *columns)
      if (std::find(headings.begin(), headings.end(), column.heading) == headings.end())
        headings.push_back(column.heading);
  return headings;
}

LogFile read_log(const std::string& path, const LogSchema& schema, double sample_period_s) {
  const CsvTable table = CsvTable::read(path);
  LogFile log;
  log.path = path;
  log.name = std::filesystem::path(path).filename().string();
  read_time(table, schema, sample_period_s, log);
  for (const std::string& heading : listed_headings(schema)) log.columns.emplace(heading, table.column(heading));
  for (Index row = 0; row < table.rows(); ++row) log.lines.push_back(table.line(row));
  return log;
}

std::vector<LogRun> split_at_gaps(const LogFile& log, double max_gap_s, std::vector<std::string>& notes) {
  std::vector<Index> starts = {0};
  Index longest = 0;  // the sample after the longest gap
  const auto step_s = [&](Index k) { return log.time_s[k] - log.time_s[k - 1]; };
  for (Index k = 1; k < log.time_s.size(); ++k) {
    if (!(step_s(k) > max_gap_s)) continue;
    starts.push_back(k);
    if (longest == 0 || step_s(k) > step_s(longest)) longest = k;
  }
  const std::size_t count = starts.size();
  starts.push_back(log.time_s.size());

  std::vector<LogRun> runs;
  std::size_t single = 0;
  for (std::size_t i = 0; i < count; ++i) {
    LogRun run;
    run.source = count == 1 ? log.name : fmt::format("{} ({} of {})", log.name, i + 1, count);
    run.first = starts[i];
    run.rows = starts[i + 1] - starts[i];
    if (run.rows < 2) {
      ++single;
      continue;
    }
    run.time_s = log.time_s.segment(run.first, run.rows).array() - log.time_s[run.first];
    run.grid = fit_time_grid(run.time_s, log.resolution_s);
    runs.push_back(std::move(run));
  }
  if (count > 1)
    notes.push_back(
        fmt::format("{}:{}: a gap of {:.4g} s, the longest of {}: the log is split into {} "
                    "runs, each from a fresh start{} (a longer [log] max_gap_s, now {:.4g} s, keeps it "
                    "whole)",
                    log.name, log.lines[static_cast<std::size_t>(longest)], step_s(longest), count - 1, count,
                    single == 0 ? "" : fmt::format("; {} of one sample are dropped", single), max_gap_s));
  return runs;
}

}  // namespace nlo::trainer
