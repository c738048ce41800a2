// SPDX-License-Identifier: MIT
#include "trainer/reproduce/contest.h"

#include <fmt/format.h>

#include <algorithm>

#include "trainer/app/report/html.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/reproduce/numbers_csv.h"
#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {
namespace {

using ContestValues = std::vector<double> Contender::*;

struct ContestReading {
  const char* name;
  ContestValues values;
};
constexpr ContestReading kContestReadings[] = {{"components", &Contender::components}, {"norms", &Contender::norms}};

double worst_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

const char* verdict(const Contender& cell, const std::vector<double>& values) {
  if (!cell.published) return "";
  return is_ahead(cell, values) ? "ahead" : "behind";
}

/// Returns a table with a row for each cell: model, condition and published error, then mean, worst seed and verdict
/// for each of the two ways to compute the error.
Table contest_table(const Contest& contest) {
  Table table{{"SMAPE in %", "published", "components", "worst", "", "norms", "worst", ""}};
  for (const Contender& cell : contest.cells) {
    auto& row = table.rows.emplace_back();
    row = {cell.model + ", " + cell.condition, significant(cell.published)};
    for (const ContestReading& reading : kContestReadings) {
      const auto& values = cell.*reading.values;
      row.insert(row.end(), {significant(spread(values).mean), significant(worst_of(values)), verdict(cell, values)});
    }
  }
  return table;
}

}  // namespace

bool is_ahead(const Contender& cell, const std::vector<double>& values) {
  return cell.published && !values.empty() && worst_of(values) < *cell.published;
}

std::string contest_score(const Contest& contest) {
  int cells = 0, components = 0, norms = 0;
  for (const Contender& cell : contest.cells) {
    cells += cell.published ? 1 : 0;
    components += is_ahead(cell, cell.components) ? 1 : 0;
    norms += is_ahead(cell, cell.norms) ? 1 : 0;
  }
  return fmt::format("{} of {} cells ahead by components, {} of {} by norms", components, cells, norms, cells);
}

std::string contest_text(const Contest& contest) {
  return contest.title + "\n" + contest_table(contest).to_text(2);
}

std::string contest_html(const Contest& contest) {
  return fmt::format("<h3>{}</h3>\n{}", escaped(contest.title), html_table(contest_table(contest)));
}

std::string contests_csv(const std::vector<Contest>& contests) {
  NumbersCsv csv;
  for (const Contest& contest : contests)
    for (const Contender& cell : contest.cells)
      for (const ContestReading& reading : kContestReadings) {
        const auto& values = cell.*reading.values;
        csv.add({contest.title, cell.model, cell.condition, reading.name, "smape"}, cell.published, values,
                cell.published ? std::optional(spread(values).mean / *cell.published - 1.0) : std::nullopt);
      }
  return csv.text();
}

}  // namespace nlo::trainer::reproduction
