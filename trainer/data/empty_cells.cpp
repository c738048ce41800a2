// SPDX-License-Identifier: MIT
#include "trainer/data/empty_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "trainer/base/quantile.h"
#include "trainer/data/zero_phase_filter.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<Index> empty_rows(const LogFile& log, const LogRun& run, const std::string& heading) {
  std::vector<Index> rows;
  if (const auto found = log.empty.find(heading); found != log.empty.end())
    for (const Index row : found->second)
      if (row >= run.first && row < run.first + run.rows) rows.push_back(row - run.first);
  return rows;
}

void draw_lines(const std::vector<Index>& rows, const VectorXd& time_s, VectorXd& values) {
  if (rows.empty()) return;
  std::vector<Index> full;
  for (Index k = 0; k < values.size(); ++k)
    if (!std::binary_search(rows.begin(), rows.end(), k)) full.push_back(k);
  if (full.empty()) return;
  values(rows) = interpolate(time_s(full), values(full), time_s(rows));
}

Index regular_spacing(const std::vector<Index>& empty, Index rows) {
  if (empty.empty()) return 0;
  constexpr std::size_t kFewest = 4;  // values
  constexpr double kNear = 0.25, kShare = 0.9;
  std::vector<Index> spacings;
  Index last = -1;
  for (Index row = 0, i = 0; row < rows; ++row) {
    if (i < static_cast<Index>(empty.size()) && empty[static_cast<std::size_t>(i)] == row) {
      ++i;
      continue;
    }
    if (last >= 0) spacings.push_back(row - last);
    last = row;
  }
  if (spacings.size() + 1 < kFewest) return 0;
  const Index usual = value_at_rank(spacings, 0.5);
  if (usual < 2) return 0;
  const auto all = static_cast<double>(spacings.size());
  const Index off = std::max<Index>(1, static_cast<Index>(kNear * static_cast<double>(usual)));
  std::erase_if(spacings, [&](Index each) { return std::abs(each - usual) > off; });
  const auto near = static_cast<double>(spacings.size());
  if (near < kShare * all) return 0;
  const Index rows_in_all = std::accumulate(spacings.begin(), spacings.end(), Index{0});
  return static_cast<Index>(std::round(static_cast<double>(rows_in_all) / near));
}

namespace {

/// Counts the cells of an output with a known period. Only samples that were due can be missing.
void count_lost(const LogFile& log, const std::vector<Index>& empty, EmptyCells& count) {
  constexpr double kLate = 1.5;  // periods, as in flight
  count.due += static_cast<Index>(std::round(log.time_s[log.time_s.size() - 1] / count.period_s)) + 1;
  for_each_stretch(empty, [&](Index first, Index last) {
    const Index before = std::max<Index>(first - 1, 0), after = std::min(last + 1, log.time_s.size() - 1);
    const double length_s = log.time_s[after] - log.time_s[before];
    if (length_s <= kLate * count.period_s) return;
    count.lost += static_cast<Index>(std::round(length_s / count.period_s)) - 1;
    if (length_s > count.longest_s) count.longest_s = length_s, count.worst = log.name;
  });
}

}  // namespace

void count_empty_cells(const LogSchema& schema, const std::vector<LogFile>& logs,
                       std::map<std::string, EmptyCells>& cells) {
  for (const std::string& heading : listed_headings(schema)) {
    EmptyCells& count = cells[heading];
    const auto is_of = [&](const std::vector<LogColumn>& columns) {
      return std::any_of(columns.begin(), columns.end(), [&](const auto& column) { return column.heading == heading; });
    };
    count.output = count.output || is_of(schema.outputs);
    count.state = count.state || is_of(schema.states);
    count.input = count.input || is_of(schema.inputs);
    for (const LogColumn& output : schema.outputs)
      if (output.heading == heading) count.period_s = output.period_s;
    for (const LogFile& log : logs) {
      count.rows += log.time_s.size();
      const auto found = log.empty.find(heading);
      if (found == log.empty.end()) continue;
      const std::vector<Index>& rows = found->second;
      if (count.period_s > 0.0) {
        count_lost(log, rows, count);
        if (!count.state && !count.input) continue;
      }
      if (count.output && count.period_s == 0.0) {
        const double steps = static_cast<double>(log.time_s.size() - 1);
        const double spacing = static_cast<double>(regular_spacing(rows, log.time_s.size()));
        count.regular_s = steps > 0.0 ? spacing * log.time_s[log.time_s.size() - 1] / steps : 0.0;
      }
      count.empty += static_cast<Index>(rows.size());
      const double share = static_cast<double>(rows.size()) / static_cast<double>(log.time_s.size());
      if (share > count.worst_share) count.worst_share = share, count.worst = log.name;
      // The time without a value lasts from the last value before the stretch (or its first row) to the next value
      // after it (or its last row).
      for_each_stretch(rows, [&](Index first, Index last) {
        const Index before = std::max<Index>(first - 1, 0), after = std::min(last + 1, log.time_s.size() - 1);
        count.longest_s = std::max(count.longest_s, log.time_s[after] - log.time_s[before]);
      });
    }
  }
}

void note_empty_cells(const std::map<std::string, EmptyCells>& cells, std::vector<std::string>& notes) {
  for (const auto& [heading, count] : cells) {
    if (count.lost > 0)
      notes.push_back(
          fmt::format("\"{}\" lacks {} of its {} samples with period_s = {:.4g} s (for up to {:.3g} s, in {}): it "
                      "holds its last value there, and in flight the status becomes kHeld, then kStale",
                      heading, count.lost, count.due, count.period_s, count.longest_s, count.worst));
    if (count.empty == 0) continue;
    const double share = static_cast<double>(count.empty) / static_cast<double>(count.rows);
    std::string what;
    const auto add = [&](const std::string& part) { what += (what.empty() ? "" : "; ") + part; };
    if (count.period_s == 0.0 && count.output && count.regular_s > 0.0)
      add(
          fmt::format("as an output it has a value every {0:.4g} s: write period_s = {0:.4g} at the column, so that "
                      "the observer does not count the empty cells as missing in flight",
                      count.regular_s));
    else if (count.period_s == 0.0 && count.output)
      add("as an output it holds its last value there, as in flight (it is missing there if [observer] may_fail names "
          "it)");
    if (count.input) add("as an input it holds its last value there");
    if (count.state) add("as a state: no state is scored in these rows");
    if (what.empty()) add("as a mask it excludes the truth there");
    notes.push_back(
        fmt::format("\"{}\" has no value in {:.3g} % of the rows ({} of {}, for up to {:.3g} s, most in {}){}: {}",
                    heading, 100.0 * share, count.empty, count.rows, count.longest_s, count.worst,
                    share > kMostlyEmpty ? ", mostly empty" : "", what));
  }
}

}  // namespace nlo::trainer
