// SPDX-License-Identifier: MIT
#include "trainer/reproduce/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "trainer/app/report/html.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/reproduce/trajectories.h"

namespace nlo::trainer::reproduction {
namespace {

struct Counts {
  int cells = 0, near = 0, claims = 0, held = 0;
};

Counts count(const Section& section) {
  Counts counts;
  for (const ComparisonTable& table : section.tables)
    for (const auto& row : table.cells)
      for (const Cell& cell : row) {
        if (!deviation_from_paper(cell)) continue;
        ++counts.cells;
        counts.near += is_outside(cell) ? 0 : 1;
      }
  for (const Ordering& ordering : section.orderings) {
    ++counts.claims;
    counts.held += std::all_of(ordering.held.begin(), ordering.held.end(), [](bool held) { return held; }) ? 1 : 0;
  }
  return counts;
}

Counts count(const Result& result) {
  Counts total;
  for (const auto& [item, section] : result.sections) {
    const Counts counts = count(section);
    total.cells += counts.cells;
    total.near += counts.near;
    total.claims += counts.claims;
    total.held += counts.held;
  }
  return total;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Returns the columns with the smallest number of a row, which are bold as in the paper.
template <class Number>
std::vector<bool> smallest(const std::vector<Cell>& row, const Number& number) {
  double best = kInfinity;
  for (const Cell& cell : row) best = std::min(best, number(cell));
  std::vector<bool> is_best;
  for (const Cell& cell : row) is_best.push_back(row.size() > 1 && number(cell) == best);
  return is_best;
}

std::string emphasised(const std::string& text, bool bold) {
  return bold ? "<b>" + text + "</b>" : text;
}

std::string ours_html(const std::vector<double>& values, bool bold) {
  const Spread ours = spread(values);
  std::string html = emphasised(significant(ours.mean), bold);
  if (values.size() > 1) html += fmt::format(" <span class=\"soft\">± {}</span>", significant(ours.deviation, 2));
  return html;
}

std::string paper_html(const Cell& cell, bool compare, bool bold) {
  if (!cell.paper) return "";
  std::string html = "<div class=\"paper\">paper " + emphasised(significant(*cell.paper), bold);
  if (const auto relative = deviation_from_paper(cell); compare && relative)
    html += fmt::format(" · <span{}>{:+.0f} %</span>", is_outside(cell) ? " class=\"far\"" : "", 100.0 * *relative);
  return html + "</div>";
}

/// Returns the table for one way to compute the errors.
std::string table_html(const ComparisonTable& table, const std::string& title, std::vector<double> Cell::*values,
                       bool compare) {
  std::string html = fmt::format("<h3>{}</h3>\n<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">{}</th>",
                                 escaped(title), escaped(table.corner));
  for (const std::string& column : table.columns) html += fmt::format("<th scope=\"col\">{}</th>", escaped(column));
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const auto& row = table.cells[r];
    const auto best = smallest(row, [values](const Cell& cell) { return spread(cell.*values).mean; });
    const auto best_paper = smallest(row, [](const Cell& cell) { return cell.paper.value_or(kInfinity); });
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escaped(table.rows[r]));
    for (std::size_t c = 0; c < row.size(); ++c)
      html += fmt::format("<td{}>{}{}</td>", compare && is_outside(row[c]) ? " class=\"outside\"" : "",
                          ours_html(row[c].*values, best[c]), paper_html(row[c], compare, best_paper[c]));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// Returns a table without numbers of the paper, with both ways to compute the errors.
std::string plain_table_html(const ComparisonTable& table) {
  std::string html =
      fmt::format("<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">{}</th>", escaped(table.corner));
  for (const std::string& column : table.columns)
    for (const char* reading : {"strict", "paper-like"})
      html += fmt::format("<th scope=\"col\">{}<br><span class=\"paper\">{}</span></th>", escaped(column), reading);
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escaped(table.rows[r]));
    for (const Cell& cell : table.cells[r])
      for (const auto* values : {&cell.strict, &cell.paper_like})
        html += values->empty() ? "<td></td>" : fmt::format("<td>{}</td>", ours_html(*values, false));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

bool has_paper_numbers(const ComparisonTable& table) {
  for (const auto& row : table.cells)
    for (const Cell& cell : row)
      if (cell.paper) return true;
  return false;
}

std::string tables_html(const Section& section) {
  std::string html;
  for (const ComparisonTable& table : section.tables) {
    if (!has_paper_numbers(table)) {
      html += plain_table_html(table);
      continue;
    }
    const std::string start = table.title.empty() ? "" : table.title + ". ";
    html +=
        table_html(table, start + "Paper-like reading: error / RMS of the state over 0-50 s", &Cell::paper_like, true);
    html += table_html(table, start + "Strict reading: error norm over 0-50 s", &Cell::strict, false);
  }
  return html;
}

/// Returns every marked cell with its explanation.
std::string explanations_html(const Section& section, bool quick) {
  std::string html;
  for (const ComparisonTable& table : section.tables)
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        const Cell& cell = table.cells[r][c];
        if (!is_outside(cell)) continue;
        const auto known =
            std::find_if(section.explanations.begin(), section.explanations.end(), [&](const Explanation& explanation) {
              return (explanation.row.empty() || explanation.row == table.rows[r]) &&
                     (explanation.column.empty() || explanation.column == table.columns[c]);
            });
        html += fmt::format("<li><b>{}, {}</b>: {:+.0f} %. {}</li>\n", escaped(table.columns[c]),
                            escaped(table.rows[r]), 100.0 * *deviation_from_paper(cell),
                            known == section.explanations.end()
                                ? (quick ? "A quick run trains too little to explain a difference." : "Not explained.")
                                : escaped(known->text));
      }
  return html.empty() ? ""
                      : fmt::format("<h3>Cells more than {:.0f} % from the paper</h3>\n<ul>\n{}</ul>\n",
                                    100.0 * kTolerance, html);
}

std::string marks_html(const std::vector<bool>& held) {
  std::string html;
  for (const bool each : held) html += each ? "<span class=\"held\">✓</span> " : "<span class=\"far\">✗</span> ";
  return html;
}

/// Returns a row for each claim, a column for each way to compute the errors, and a mark for each seed.
std::string orderings_html(const Section& section) {
  if (section.orderings.empty()) return "";
  std::vector<std::string> claims, readings;
  const auto note_once = [](std::vector<std::string>& known, const std::string& name) {
    if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
  };
  for (const Ordering& ordering : section.orderings) {
    note_once(claims, ordering.claim);
    note_once(readings, ordering.reading);
  }
  std::string html =
      "<h3>Claims, seed by seed</h3>\n<div class=\"wide\"><table class=\"claims\">\n<thead><tr><th "
      "scope=\"col\">claim</th>";
  for (const std::string& reading : readings) html += fmt::format("<th scope=\"col\">{}</th>", escaped(reading));
  html += "</tr></thead>\n<tbody>\n";
  for (const std::string& claim : claims) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escaped(claim));
    for (const std::string& reading : readings) {
      const auto found = std::find_if(
          section.orderings.begin(), section.orderings.end(),
          [&](const Ordering& ordering) { return ordering.claim == claim && ordering.reading == reading; });
      html += fmt::format("<td>{}</td>", found == section.orderings.end() ? "" : marks_html(found->held));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n<p class=\"soft\">✓ held, ✗ not held, one mark per training seed.</p>\n";
}

std::string reports_html(const Item& item, const Section& section) {
  return fmt::format(
      "<p class=\"soft\">Paper: <code>{}</code> · alone: <code>nlo reproduce {}</code></p>\n"
      "<dl class=\"reports\"><dt>The paper reports</dt><dd>{}</dd><dt>We see</dt><dd>{}</dd></dl>\n",
      escaped(item.label), escaped(item.name), escaped(item.paper_reports), escaped(section.seen));
}

std::string tile(const std::string& value, const std::string& meaning) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span></div>\n", escaped(value), escaped(meaning));
}

std::string contents_html(const Result& result) {
  std::string html = "<ol class=\"contents\">\n";
  for (const auto& [item, section] : result.sections)
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", escaped(item->name), escaped(item->title));
  return html + "</ol>\n";
}

std::string head_html(const Request& request, const Result& result) {
  std::string html =
      "<h1>The paper, reproduced</h1>\n"
      "<p class=\"soft\">Miao and Gatsis, “Learning Robust State Observers using Neural ODEs”: its tables and figures "
      "beside ours, each from observers trained for this page.</p>\n";
  if (request.quick)
    html +=
        note(fmt::format("A quick run: {:.0f} % of the training steps, {} training {}, {} test trajectories, maps of "
                         "{} x {} states. It only gives a first impression; use the numbers of a run without --quick.",
                         100.0 * request.size.steps, request.seeds, request.seeds == 1 ? "seed" : "seeds",
                         request.size.test_trajectories, request.size.map_points, request.size.map_points));
  const Counts counts = count(result);
  html += "<div class=\"tiles\">\n";
  if (counts.cells > 0)
    html += tile(fmt::format("{} of {}", counts.near, counts.cells),
                 fmt::format("numbers within {:.0f} % of the paper (paper-like reading)", 100.0 * kTolerance));
  if (counts.claims > 0)
    html += tile(fmt::format("{} of {}", counts.held, counts.claims), "claims held for every seed");
  html += tile(std::to_string(result.trainings.done + result.trainings.found), "trained observers");
  html += tile(std::to_string(request.seeds), request.seeds == 1 ? "training seed" : "training seeds per observer");
  return html + "</div>\n" + contents_html(result);
}

std::string method_html(const Workbench& bench) {
  std::string html = fmt::format(
      "<h2 id=\"method\">How these numbers are made</h2>\n<p>The paper does not define its metric, test set and noise "
      "model, so errors are computed in two ways (readings). Each number is the mean over training seeds with the "
      "population standard deviation. All observers have the same test set: {} initial states, uniform over the "
      "training box, z(0) = 0, RK4 at 0.02 s over 50 s. Bold: the smallest of a row.</p>\n<dl "
      "class=\"reports\"><dt>strict</dt><dd>one independent noise value per sample, as from a sensor; error norm "
      "sqrt(mean |x - x̂|²) over the whole run, including the transient. N(0, 0.5) means a standard deviation of "
      "0.5.</dd>\n<dt>paper-like</dt><dd>plant and observer are integrated together, with a new noise value at each of "
      "the four Runge-Kutta stages, which averages the noise within a step; the error is divided by the RMS of the "
      "state. This reading fits the paper's numbers best among those that we tried, so cells are compared with the "
      "paper in this reading.</dd></dl>\n<p>Training uses 4,096 random samples per step instead of full batches. This "
      "gives the same errors in a twentieth of the time. The paper's figures come without data, so our curves are "
      "compared with its text.</p>\n",
      bench.size.test_trajectories);
  for (const auto& [name, experiment] : bench.experiments)
    html += fmt::format("<details><summary>Experiment {}</summary><pre>{}</pre></details>\n", escaped(name),
                        escaped(experiment.source_text));
  return html;
}

}  // namespace

std::string page_html(const Request& request, const Result& result, const Workbench& bench,
                      const std::string& gnuplot) {
  Page page;
  page.text(head_html(request, result));
  for (const auto& [item, section] : result.sections) {
    page.text(fmt::format("<h2 id=\"{}\">{}</h2>\n{}", escaped(item->name), escaped(item->title),
                          reports_html(*item, section)));
    for (const Figure& figure : section.figures) page.figure(figure);
    for (const Contest& contest : section.contests) page.text(contest_html(contest));
    for (const ExamTable& exam : section.exams) page.text(exam_html(exam));
    page.text(tables_html(section) + explanations_html(section, request.quick) + orderings_html(section));
  }
  page.text(method_html(bench));
  return html_page("The paper, reproduced", page.html(gnuplot));
}

std::string summary_text(const Result& result) {
  std::string text;
  for (const auto& [item, section] : result.sections) {
    text += fmt::format("{} ({})\n", item->title, item->name);
    for (const ComparisonTable& table : section.tables) {
      Table lines{{"", "paper", "paper-like", "strict"}};
      for (std::size_t r = 0; r < table.rows.size(); ++r)
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
          const Cell& cell = table.cells[r][c];
          lines.add_row({table.rows[r] + ", " + table.columns[c], cell.paper ? significant(*cell.paper) : "-",
                         spread_text(cell.paper_like) + (is_outside(cell) ? " !" : "  "), spread_text(cell.strict)});
        }
      text += "\n" + lines.to_text(2);
    }
    for (const Contest& contest : section.contests) text += "\n" + contest_text(contest);
    for (const ExamTable& exam : section.exams) text += "\n" + exam_text(exam);
    if (!section.exams.empty()) text += "\n  " + section.seen + "\n";
    const Counts counts = count(section);
    if (counts.claims > 0) text += fmt::format("\n  {} of {} claims held for every seed\n", counts.held, counts.claims);
    text += "\n";
  }
  for (const std::string& why : result.left_out) text += "left out: " + why + "\n";
  return text;
}

}  // namespace nlo::trainer::reproduction
