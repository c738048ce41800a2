// SPDX-License-Identifier: MIT
#include "trainer/data/empty_cells.h"

#include <fmt/format.h>

#include <algorithm>

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
    for (const LogFile& log : logs) {
      count.rows += log.time_s.size();
      const auto found = log.empty.find(heading);
      if (found == log.empty.end()) continue;
      const std::vector<Index>& rows = found->second;
      count.empty += static_cast<Index>(rows.size());
      const double share = static_cast<double>(rows.size()) / static_cast<double>(log.time_s.size());
      if (share > count.worst_share) count.worst_share = share, count.worst = log.name;
      // From the value before the stretch, or its first row, to the value after it, or its last row.
      for_each_stretch(rows, [&](Index first, Index last) {
        const Index before = std::max<Index>(first - 1, 0), after = std::min(last + 1, log.time_s.size() - 1);
        count.longest_s = std::max(count.longest_s, log.time_s[after] - log.time_s[before]);
      });
    }
  }
}

void note_empty_cells(const std::map<std::string, EmptyCells>& cells, std::vector<std::string>& notes) {
  for (const auto& [heading, count] : cells) {
    if (count.empty == 0) continue;
    const double share = static_cast<double>(count.empty) / static_cast<double>(count.rows);
    std::string what;
    const auto add = [&](const std::string& part) { what += (what.empty() ? "" : "; ") + part; };
    if (count.output)
      add("as an output it holds its last value there, as in flight (where [observer] may_fail names it, it is "
          "missing)");
    if (count.input) add("as an input it holds its last value there");
    if (count.state) add("as a state it is not scored there, nor is any other state of the row");
    if (what.empty()) add("as a mask it lets no truth count there");
    notes.push_back(
        fmt::format("\"{}\" has no value in {:.3g} % of the rows ({} of {}, for up to {:.3g} s, most in {}){}: {}",
                    heading, 100.0 * share, count.empty, count.rows, count.longest_s, count.worst,
                    share > kMostlyEmpty ? ", mostly empty" : "", what));
  }
}

}  // namespace nlo::trainer
