// SPDX-License-Identifier: MIT
#include "trainer/reproduce/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "trainer/base/number_text.h"

namespace nlo::trainer::reproduction {
namespace {

/// A field of text; quoted when it must be.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string cell_lines(const ComparisonTable& table, std::size_t row, std::size_t column) {
  const Cell& cell = table.cells[row][column];
  std::string text;
  const auto line = [&](const char* reading, const char* metric, const std::vector<double>& values, bool compare) {
    if (values.empty()) return;
    const Spread ours = spread(values);
    const auto relative = compare ? deviation_from_paper(cell) : std::nullopt;
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{}", field(table.title), field(table.rows[row]),
                    field(table.columns[column]), reading, metric, cell.paper ? shortest_text(*cell.paper) : "",
                    shortest_text(ours.mean), shortest_text(ours.deviation), relative ? shortest_text(*relative) : "");
    for (const double value : values) text += "," + shortest_text(value);
    text += '\n';
  };
  line("strict", "norm", cell.strict, false);
  line("paper-like", "nrmse", cell.paper_like, true);
  return text;
}

}  // namespace

std::string numbers_csv(const Section& section) {
  std::size_t seeds = 0;
  std::string lines;
  for (const ComparisonTable& table : section.tables)
    for (std::size_t row = 0; row < table.rows.size(); ++row)
      for (std::size_t column = 0; column < table.columns.size(); ++column) {
        lines += cell_lines(table, row, column);
        const Cell& cell = table.cells[row][column];
        seeds = std::max({seeds, cell.strict.size(), cell.paper_like.size()});
      }
  if (lines.empty()) return "";
  std::string heading = "table,row,column,reading,metric,paper,mean,deviation,relative_to_paper";
  for (std::size_t seed = 1; seed <= seeds; ++seed) heading += fmt::format(",seed_{}", seed);
  return heading + "\n" + lines;
}

std::string columns_csv(const std::vector<std::pair<std::string, Eigen::VectorXd>>& columns) {
  std::string text;
  for (std::size_t i = 0; i < columns.size(); ++i) text += (i == 0 ? "" : ",") + field(columns[i].first);
  text += '\n';
  for (Eigen::Index k = 0; k < columns.front().second.size(); ++k) {
    for (std::size_t i = 0; i < columns.size(); ++i) text += (i == 0 ? "" : ",") + shortest_text(columns[i].second[k]);
    text += '\n';
  }
  return text;
}

}  // namespace nlo::trainer::reproduction
