// SPDX-License-Identifier: MIT
#include "trainer/app/report/pages.h"

#include <fmt/format.h>

#include <tuple>
#include <utility>
#include <vector>

#include "trainer/app/report/html.h"
#include "trainer/app/report/pareto_figure.h"

namespace nlo::trainer {
namespace {

/// Shows each candidate at its last training.
Figure errors_and_costs(const SearchRecord& record) {
  std::vector<PointResult> points;
  for (std::size_t c = 0; c < record.candidates.size(); ++c) {
    const Trial* last = record.last_of(c);
    if (last == nullptr || !last->error) continue;
    PointResult& point = points.emplace_back();
    point.error = last->error;
    point.cost = record.candidates[c].cost;
    point.title = title_of(record.candidates[c]);
  }
  mark_fronts(points);
  Figure figure = pareto_figure(points);
  figure.caption =
      "Each candidate with its last error. Candidates that were given up had less training than the others.";
  return figure;
}

/// Shows the errors of the candidates over the rungs.
Figure races(const SearchRecord& record) {
  Figure figure;
  if (record.rungs.size() < 2) return figure;
  Panel panel;
  panel.x_label = "steps of training";
  panel.y_label = "error";
  panel.log_x = panel.log_y = true;
  const std::size_t chosen = record.chosen().candidate;
  for (std::size_t c = 0; c < record.candidates.size(); ++c) {
    std::vector<std::pair<double, double>> places;
    for (const std::vector<Trial>& rung : record.rungs)
      for (const Trial& trial : rung)
        if (trial.candidate == c && trial.error) places.emplace_back(trial.steps, *trial.error);
    if (places.size() < 2) continue;
    const auto count = static_cast<Eigen::Index>(places.size());
    Series series{c == chosen                        ? "chosen"
                  : c == 0 && record.by_hand_s > 0.0 ? "unchanged"
                                                     : "",
                  c == chosen ? Series::Style::kLine : Series::Style::kThinLine,
                  c == chosen                        ? 1
                  : c == 0 && record.by_hand_s > 0.0 ? 2
                                                     : 5,
                  Eigen::VectorXd(count),
                  Eigen::VectorXd(count),
                  {}};
    for (Eigen::Index i = 0; i < count; ++i) std::tie(series.x[i], series.y[i]) = places[static_cast<std::size_t>(i)];
    panel.series.push_back(std::move(series));
  }
  if (panel.series.empty()) return figure;
  figure.panels.push_back(std::move(panel));
  figure.panel_height = 340;
  figure.caption = "The race: candidates that were trained more than once.";
  return figure;
}

}  // namespace

std::string search_page(const SearchStory& story, const std::string& gnuplot) {
  Page page;
  const std::vector<std::string> findings = search_findings(story);
  page.text(fmt::format("<h1>{}: a search</h1>\n<p class=\"soft\">{}</p>\n<p class=\"summary\">{}</p>\n",
                        escaped(story.experiment), escaped(story.command), escaped(findings.front())));
  page.figure(errors_and_costs(story.record));
  page.figure(races(story.record));
  page.heading("What was tried");
  Table table = search_table(story);
  table.headings.front() = table.headings.back();  // the name of a row comes first
  table.headings.pop_back();
  for (auto& row : table.rows) {
    row.front() = row.back() + (row.front().empty() ? "" : " (chosen)");
    row.pop_back();
  }
  page.text(html_table(table));
  std::string list;
  for (std::size_t i = 1; i < findings.size(); ++i) list += fmt::format("<li>{}</li>\n", escaped(findings[i]));
  page.text(fmt::format("<ul>\n{}</ul>\n", list));
  return html_page(story.experiment + " - a search", page.html(gnuplot));
}

}  // namespace nlo::trainer
