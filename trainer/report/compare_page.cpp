// SPDX-License-Identifier: MIT
#include "trainer/report/compare_page.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "trainer/compare/compare_text.h"
#include "trainer/report/gnuplot.h"
#include "trainer/report/html.h"
#include "trainer/report/page.h"
#include "trainer/report/run_figure.h"

namespace nlo::trainer {
namespace {

/// Each column's error over that of the reference, condition by condition.
Figure ratios(const Comparison& comparison, std::size_t reference) {
  Figure figure;
  Panel panel;
  panel.x_label = "condition, in the order of the table";
  panel.y_label = "error / " + comparison.columns[reference].name;
  panel.log_y = true;
  const auto count = static_cast<Eigen::Index>(comparison.conditions.size());
  int colour = 0;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    Eigen::VectorXd ratio(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const CompareCell &own = comparison.cell(static_cast<std::size_t>(i), c),
                        &other = comparison.cell(static_cast<std::size_t>(i), reference);
      ratio[i] = own.missing.empty() && other.missing.empty() ? own.mean() / other.mean() : std::nan("");
    }
    if (!(ratio.array() == ratio.array()).any()) continue;
    const bool marked = comparison.columns[c].is_observer;
    panel.series.push_back({comparison.columns[c].name,
                            marked ? Series::Style::kLine : Series::Style::kThinLine,
                            colour++,
                            Eigen::VectorXd::LinSpaced(count, 1.0, static_cast<double>(count)),
                            ratio,
                            {}});
  }
  figure.panels.push_back(std::move(panel));
  figure.panel_height = 340;
  figure.caption = fmt::format("Errors over that of {}: below 1 is better.", comparison.columns[reference].name);
  return figure;
}

std::size_t reference_column(const Comparison& comparison) {
  std::size_t found = 0;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c)
    if (comparison.columns[c].name == "ekf_tuned" || (found == 0 && comparison.columns[c].name == "ekf")) found = c;
  return found;
}

void add_table(Page& page, const CompareTable& table) {
  page.text(html_table(table.headings, table.rows));
}

}  // namespace

std::string compare_page(const Comparison& comparison, const std::string& gnuplot) {
  Page page;
  page.text(fmt::format("<h1>{}: observers and filters</h1>\n<p class=\"soft\">{}.</p>\n",
                        escaped(comparison.experiment), escaped(comparison_conditions(comparison))));
  const std::vector<std::string> findings = comparison_findings(comparison);
  if (!findings.empty()) page.text(fmt::format("<p class=\"summary\">{}</p>\n", escaped(findings.front())));
  page.heading("Errors");
  add_table(page, error_table(comparison));
  page.text("<p class=\"soft\">A star marks the least error of a row, but for a floor that knows the condition.</p>\n");
  if (const std::size_t reference = reference_column(comparison); reference > 0)
    page.figure(ratios(comparison, reference));
  std::string list;
  for (const std::string& finding : findings) list += fmt::format("<li>{}</li>\n", escaped(finding));
  if (!list.empty()) page.text(fmt::format("<ul>\n{}</ul>\n", list));
  page.heading("Conditions");
  std::vector<std::vector<std::string>> conditions;
  for (const Condition& condition : comparison.conditions)
    conditions.push_back({condition.name, condition_title(condition)});
  page.text(html_table({"condition", "what it is"}, conditions));
  page.heading("What was compared");
  std::vector<std::vector<std::string>> columns;
  for (const CompareColumn& column : comparison.columns) columns.push_back({column.name, column.meaning});
  page.text(html_table({"column", "what it is"}, columns));
  page.heading("The worst runs");
  add_table(page, worst_table(comparison));
  page.text(fmt::format("<p>The run on which {} is furthest off, under {}:</p>\n",
                        escaped(comparison.columns.front().name),
                        escaped(comparison.conditions[comparison.worst_condition].name)));
  for (const EvaluatedRun& run : comparison.worst) page.figure(run_picture(run, comparison.states, comparison.outputs));
  if (const CompareTable tuning = tuning_table(comparison); !tuning.rows.empty()) {
    page.heading("How the filters were tuned");
    add_table(page, tuning);
  }
  page.heading("What a step costs");
  add_table(page, cost_table(comparison));
  page.text(
      "<p class=\"soft\">Operations are counted: additions, multiplications, divisions; a multiply-add is two. "
      "Functions "
      "are square roots, powers, sines, activations. Bytes are of float. Times are of this run and this program, where "
      "filters step many runs side by side and observers take a run at a time: bench/step_latency measures what "
      "flies.</p>\n");
  return html_page(comparison.experiment + " - observers and filters", page.html(gnuplot));
}

}  // namespace nlo::trainer
