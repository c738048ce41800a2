// SPDX-License-Identifier: MIT
#include "trainer/reproduce/numbers_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "trainer/base/number_text.h"

namespace nlo::trainer::reproduction {
namespace {

/// Returns a text field, with quotes if necessary.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

void NumbersCsv::add(const std::vector<std::string>& cell, const std::optional<double>& paper,
                     const std::vector<double>& values, const std::optional<double>& relative_to_paper) {
  if (values.empty()) return;
  const auto number = [](const std::optional<double>& value) { return value ? shortest_text(*value) : ""; };
  const Spread ours = spread(values);
  for (const std::string& text : cell) lines_ += field(text) + ",";
  lines_ += fmt::format("{},{},{},{}", number(paper), shortest_text(ours.mean), shortest_text(ours.deviation),
                        number(relative_to_paper));
  for (const double value : values) lines_ += "," + shortest_text(value);
  lines_ += '\n';
  seeds_ = std::max(seeds_, values.size());
}

std::string NumbersCsv::text() const {
  if (lines_.empty()) return "";
  std::string heading = "table,row,column,reading,metric,paper,mean,deviation,relative_to_paper";
  for (std::size_t seed = 1; seed <= seeds_; ++seed) heading += fmt::format(",seed_{}", seed);
  return heading + "\n" + lines_;
}

std::string numbers_csv(const Section& section) {
  NumbersCsv csv;
  for (const ComparisonTable& table : section.tables)
    for (std::size_t row = 0; row < table.rows.size(); ++row)
      for (std::size_t column = 0; column < table.columns.size(); ++column) {
        const Cell& cell = table.cells[row][column];
        csv.add({table.title, table.rows[row], table.columns[column], "strict", "norm"}, cell.paper, cell.strict, {});
        csv.add({table.title, table.rows[row], table.columns[column], "paper-like", "nrmse"}, cell.paper,
                cell.paper_like, deviation_from_paper(cell));
      }
  return csv.text();
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
