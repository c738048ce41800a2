// SPDX-License-Identifier: MIT
#include "trainer/app/report/pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/html.h"
#include "trainer/app/report/run_figure.h"
#include "trainer/judge/compare/compare_text.h"

namespace nlo::trainer {
namespace {

using Style = Series::Style;

/// Returns a colour for each observer and each kind of filter, shipped or tuned, at most kMost; further ones share the
/// last colour, grey.
std::vector<int> colours(const Study& study) {
  constexpr int kOrder[] = {1, 0, 2, 3, 4, 5};  // observers come first
  constexpr std::size_t kMost = std::size(kOrder);
  std::vector<std::string> families;
  std::vector<int> result;
  for (const StudyEstimator& column : study.estimators) {
    const std::string name = column.untuned_name();
    const auto found = std::find(families.begin(), families.end(), name);
    const auto number = static_cast<std::size_t>(found - families.begin());
    if (found == families.end()) families.push_back(name);
    result.push_back(column.name == kParticle ? kOrder[kMost - 1] : kOrder[std::min(number, kMost - 1)]);
  }
  return result;
}

/// Draws a line for each condition, in the order of the table, with the ratio of each column's error to that of the
/// reference.
Figure ratios(const Study& study, std::size_t reference) {
  const auto count = static_cast<Eigen::Index>(study.test.conditions.size());
  const std::string rival = column_title(study.estimators[reference]);
  Panel panel;
  panel.x_label = fmt::format("error / error of the {}", rival);
  panel.log_x = true;
  panel.y_low = 0.4;
  panel.y_high = static_cast<double>(count) + 0.6;
  for (Eigen::Index i = count - 1; i >= 0; --i)  // from below
    panel.y_names.push_back(condition_name(study.test.conditions[static_cast<std::size_t>(i)]));
  panel.series.push_back({fmt::format("{} = 1", rival),
                          Style::kThinLine,
                          5,
                          Eigen::Vector2d(1.0, 1.0),
                          Eigen::Vector2d(panel.y_low, panel.y_high),
                          {}});
  const std::vector<int> colour = colours(study);
  std::vector<Series> observers;
  for (std::size_t c = 0; c < study.estimators.size(); ++c) {
    if (c == reference) continue;
    Eigen::VectorXd ratio(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const StudyCell &own = study.cell(static_cast<std::size_t>(i), c),
                      &other = study.cell(static_cast<std::size_t>(i), reference);
      ratio[i] = own.missing.empty() && other.missing.empty() ? norm_of(own).mean / norm_of(other).mean : std::nan("");
    }
    if (!(ratio.array() == ratio.array()).any()) continue;
    const StudyEstimator& column = study.estimators[c];
    const Style mark = column.is_observer         ? Style::kDiamonds
                       : column.name == kParticle ? Style::kCrosses
                       : column.is_tuned()        ? Style::kPoints
                                                  : Style::kRings;
    (column.is_observer ? observers : panel.series)
        .push_back({column_title(column),
                    mark,
                    colour[c],
                    ratio,
                    Eigen::VectorXd::LinSpaced(count, static_cast<double>(count), 1.0),
                    {}});
  }
  panel.series.insert(panel.series.end(), observers.begin(), observers.end());  // in front
  Figure figure;
  figure.width = 960;
  figure.panel_height = static_cast<int>(130 + 24 * count);
  figure.panels.push_back(std::move(panel));
  figure.caption = fmt::format(
      "One line for each condition: errors divided by that of the {}; left of 1 is better. The scale is logarithmic.{}",
      rival, study.test.tune ? " Filled: a filter tuned for the condition; ring: as shipped." : "");
  return figure;
}

std::size_t reference_column(const Study& study) {
  std::size_t found = 0;
  for (std::size_t c = 0; c < study.estimators.size(); ++c)
    if (study.estimators[c].name == "ekf_tuned" || (found == 0 && study.estimators[c].name == "ekf")) found = c;
  return found;
}

/// Puts the text after a number below it: "0.117 ± 0.02 *".
Table narrow(Table table) {
  constexpr std::string_view kBetween = " ± ", kStar = " *";
  for (auto& row : table.rows)
    for (std::string& cell : row) {
      const auto at = cell.find(kBetween);
      if (at == std::string::npos) continue;
      const bool star = cell.ends_with(kStar);
      if (star) cell.resize(cell.size() - kStar.size());
      cell.replace(at, 1, star ? " *\n" : "\n");
    }
  return table;
}

}  // namespace

std::string compare_page(const Study& study, const std::string& gnuplot) {
  Page page;
  page.text(fmt::format("<h1>{}: observers and filters</h1>\n<p class=\"soft\">{}.</p>\n", escaped(study.experiment),
                        escaped(comparison_conditions(study))));
  const std::vector<std::string> findings = comparison_findings(study);
  if (const std::string summary = comparison_summary(study); !summary.empty())
    page.text(fmt::format("<p class=\"summary\">{}</p>\n", escaped(summary)));
  page.heading("Errors");
  if (const std::size_t reference = reference_column(study); reference > 0) page.figure(ratios(study, reference));
  page.text(html_table(narrow(error_table(study))));
  const bool floor = std::ranges::any_of(study.estimators, [](const auto& c) { return c.name == kParticle; });
  page.text(fmt::format(
      "<p class=\"soft\">A star marks the smallest error of a row{}.</p>\n",
      floor ? ", except for the particle filter, which knows the condition and has the smallest possible error" : ""));
  std::string list;
  for (const std::string& finding : findings) list += fmt::format("<li>{}</li>\n", escaped(finding));
  if (!list.empty()) page.text(fmt::format("<ul>\n{}</ul>\n", list));
  page.heading("Conditions");
  Table conditions{{"condition", "what it is"}};
  for (const Condition& condition : study.test.conditions)
    conditions.add_row({condition_name(condition), condition_title(condition)});
  page.text(html_table(conditions));
  page.heading("What was compared");
  Table columns{{"column", "what it is"}};
  for (const StudyEstimator& column : study.estimators) columns.add_row({column_title(column), column.meaning});
  page.text(html_table(columns));
  page.heading("The worst runs");
  page.text(html_table(worst_table(study)));
  page.text(fmt::format("<p>The run with the largest error of {}, under {}:</p>\n",
                        escaped(study.estimators.front().name),
                        escaped(condition_name(study.test.conditions[study.worst_row]))));
  const Evaluation& first = study.cell(0, 0).first();
  for (const EvaluatedRun& run : study.worst) page.figure(run_picture(run, first.states, first.outputs));
  if (const Table tuning = tuning_table(study); !tuning.rows.empty()) {
    page.heading("How the filters were tuned");
    page.text(html_table(tuning));
  }
  page.heading("What a step costs");
  page.text(html_table(cost_table(study)));
  page.text(
      "<p class=\"soft\">Operations are counted: additions, multiplications, divisions; a multiply-add is two. "
      "Functions "
      "are square roots, powers, sines, activations. Bytes are those of float. Times were measured in this run of this "
      "program, which steps filters over many runs at once and observers over one run at a time; bench/step_latency "
      "measures the exported code.</p>\n");
  return html_page(study.experiment + " - observers and filters", page.html(gnuplot));
}

}  // namespace nlo::trainer
