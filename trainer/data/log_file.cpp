// SPDX-License-Identifier: MIT
#include "trainer/data/log_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/csv.h"
#include "trainer/data/log_stamps.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

void read_time(const CsvTable& table, const LogSchema& schema, double sample_period_s, LogFile& log,
               std::vector<Index>& rows) {
  if (table.rows() < 2)
    throw Error(fmt::format("{}: has only one data row: expected a log of at least two samples", table.file()));
  if (schema.time_heading.empty()) {
    log.time_s = VectorXd::LinSpaced(table.rows(), 0.0, sample_period_s * static_cast<double>(table.rows() - 1));
    rows.resize(static_cast<std::size_t>(table.rows()));
    std::iota(rows.begin(), rows.end(), Index{0});
    return;
  }
  LogStamps stamps = read_stamps(table, schema.time_heading, schema.time_unit_s);
  log.time_s = std::move(stamps.time_s);
  log.restarts = std::move(stamps.restarts);
  log.start_s = stamps.start_s;
  log.resolution_s = stamps.resolution_s;
  log.has_time_unit = schema.has_time_unit || stamps.is_text;
  log.clock_notes = std::move(stamps.notes);
  rows = std::move(stamps.rows);
}

/// Removes the rows that the clock has removed from a column, and updates its missing rows.
void keep_rows(const std::vector<Index>& rows, VectorXd& values, std::vector<Index>& missing) {
  if (static_cast<Index>(rows.size()) == values.size()) return;
  std::vector<Index> still;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    values[static_cast<Index>(k)] = values[rows[k]];
    if (std::binary_search(missing.begin(), missing.end(), rows[k])) still.push_back(static_cast<Index>(k));
  }
  values.conservativeResize(static_cast<Index>(rows.size()));
  missing = std::move(still);
}

/// Fills the empty cells `rows` as LogFile::columns describes. `rows` is sorted, and at least one row has a value.
void hold_last(const std::vector<Index>& rows, VectorXd& values) {
  std::size_t leading = 0;
  while (leading < rows.size() && rows[leading] == static_cast<Index>(leading)) ++leading;
  values.head(static_cast<Index>(leading)).setConstant(values[static_cast<Index>(leading)]);
  for (std::size_t i = leading; i < rows.size(); ++i) values[rows[i]] = values[rows[i] - 1];
}

/// Throws Error for a column without a value. The error lists all columns that are mostly empty, so that a user
/// corrects them at once.
void check_empty(const LogFile& log) {
  std::string whole, most;
  for (const auto& [heading, rows] : log.empty) {
    const double share = static_cast<double>(rows.size()) / static_cast<double>(log.time_s.size());
    if (share == 1.0) whole += fmt::format("{}\"{}\"", whole.empty() ? "" : ", ", heading);
    if (share > kMostlyEmpty && share < 1.0)
      most += fmt::format("{}\"{}\" ({:.3g} %)", most.empty() ? "" : ", ", heading, 100.0 * share);
  }
  if (whole.empty()) return;
  throw Error(
      fmt::format("{}: no row has a value of {}{}: leave the log out, or remove the column from [[log.columns]]",
                  log.path, whole, most.empty() ? "" : fmt::format("; mostly empty: {}", most)));
}

/// Returns the number of first rows of a stretch before every needed column has had a value.
Index rows_without_values(const LogFile& log, Index first, Index rows) {
  Index late = 0;
  for (const std::string& heading : log.needed) {
    const auto found = log.empty.find(heading);
    if (found == log.empty.end()) continue;
    const auto& missing = found->second;
    auto at = std::lower_bound(missing.begin(), missing.end(), first);
    Index row = first;
    for (; at != missing.end() && *at == row && row < first + rows; ++at) ++row;
    late = std::max(late, row - first);
  }
  return late;
}

/// Returns the cells that mean no value under `heading`, which several columns may read.
std::vector<std::string> missing_cells(const LogSchema& schema, const std::string& heading) {
  std::vector<std::string> cells = schema.missing;
  for (const auto* columns : {&schema.outputs, &schema.states, &schema.inputs, &schema.masks})
    for (const LogColumn& column : *columns)
      if (column.heading == heading) cells.insert(cells.end(), column.missing.begin(), column.missing.end());
  return cells;
}

}  // namespace

std::vector<std::string> listed_headings(const LogSchema& schema) {
  std::vector<std::string> headings;
  for (const auto* columns : {&schema.outputs, &schema.states, &schema.inputs, &schema.masks})
    for (const LogColumn& column : *columns)
      if (std::find(headings.begin(), headings.end(), column.heading) == headings.end())
        headings.push_back(column.heading);
  return headings;
}

VectorXd LogFile::values(const LogColumn& column) const {
  const VectorXd& cells = this->column(column.heading);
  if (column.scale == 1.0 && column.offset == 0.0) return cells;
  return column.scale * cells.array() + column.offset;
}

LogFile read_log(const std::string& path, const LogSchema& schema, double sample_period_s) {
  const CsvTable table = CsvTable::read(path, schema.format);
  LogFile log;
  log.path = path;
  log.name = std::filesystem::path(path).filename().string();
  std::vector<Index> kept;
  read_time(table, schema, sample_period_s, log, kept);
  for (const std::string& heading : listed_headings(schema)) {
    std::vector<Index> missing;
    VectorXd values = table.column(heading, missing, missing_cells(schema, heading));
    keep_rows(kept, values, missing);
    log.columns.emplace(heading, std::move(values));
    if (!missing.empty()) log.empty.emplace(heading, std::move(missing));
  }
  check_empty(log);
  for (const auto& [heading, rows] : log.empty) hold_last(rows, log.columns.at(heading));
  for (const auto* columns : {&schema.outputs, &schema.inputs})
    for (const LogColumn& column : *columns) log.needed.push_back(column.heading);
  for (const Index row : kept) log.lines.push_back(table.line(row));
  return log;
}

std::vector<LogRun> split_at_gaps(const LogFile& log, double max_gap_s, std::vector<std::string>& notes) {
  notes.insert(notes.end(), log.clock_notes.begin(), log.clock_notes.end());
  std::vector<Index> starts = {0};
  Index longest = 0;  // index of the sample after the longest gap
  std::size_t gaps = 0;
  const auto step_s = [&](Index k) { return log.time_s[k] - log.time_s[k - 1]; };
  for (Index k = 1; k < log.time_s.size(); ++k) {
    const bool restarts = std::binary_search(log.restarts.begin(), log.restarts.end(), k);
    if (!restarts && !(step_s(k) > max_gap_s)) continue;
    starts.push_back(k);
    if (restarts) continue;
    ++gaps;
    if (longest == 0 || step_s(k) > step_s(longest)) longest = k;
  }
  const std::size_t count = starts.size();
  starts.push_back(log.time_s.size());

  std::vector<LogRun> runs;
  std::size_t single = 0;
  Index late = 0;
  for (std::size_t i = 0; i < count; ++i) {
    LogRun run;
    run.source = count == 1 ? log.name : fmt::format("{} ({} of {})", log.name, i + 1, count);
    run.first = starts[i];
    run.rows = starts[i + 1] - starts[i];
    const Index without = rows_without_values(log, run.first, run.rows);
    late += without;
    run.first += without;
    run.rows -= without;
    if (run.rows < 2) {
      ++single;
      continue;
    }
    run.time_s = log.time_s.segment(run.first, run.rows).array() - log.time_s[run.first];
    run.grid = fit_time_grid(run.time_s, log.resolution_s);
    runs.push_back(std::move(run));
  }
  if (late > 0)
    notes.push_back(fmt::format(
        "{}: {} rows at the start of runs are left out, because an output or an input does not have a value yet",
        log.name, late));
  if (gaps > 0)
    notes.push_back(
        fmt::format("{}:{}: a gap of {:.4g} s, the longest of {}: the log is split into {} runs, and the observer "
                    "starts again in each{} (a longer [log] max_gap_s, now {:.4g} s, keeps it whole)",
                    log.name, log.lines[static_cast<std::size_t>(longest)], step_s(longest), gaps, count,
                    single == 0 ? "" : fmt::format("; {} of at most one sample are dropped", single), max_gap_s));
  return runs;
}

}  // namespace nlo::trainer
