// SPDX-License-Identifier: MIT
#include "trainer/report/pages.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "trainer/bounds/bound_text.h"
#include "trainer/report/gnuplot.h"
#include "trainer/report/html.h"

namespace nlo::trainer {
namespace {

using Value = std::function<double(const BoundResult&)>;
using Style = Series::Style;

enum Colour { kMeasured, kSlopes, kWeights, kPaper, kOffset, kBox };

Eigen::VectorXd values(const BoundReport& report, const Value& value) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(report.results.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    const double v = value(report.results[static_cast<std::size_t>(i)]);
    result(i) = v > 0.0 && std::isfinite(v) ? v : std::nan("");  // logarithmic axes
  }
  return result;
}

double k_of(const BoundResult& r) {
  return r.k;
}
double measured_s(const BoundResult& r) {
  return r.measured.transient_s.value_or(std::nan(""));
}
double measured_error(const BoundResult& r) {
  return r.measured.steady_max;
}
Value bounds_s(BoundKind kind) {
  return [kind](const BoundResult& r) { return r.transient_s[kind]; };
}
Value bounds_error(BoundKind kind) {
  return [kind](const BoundResult& r) { return r.bounds[kind].steady; };
}

Panel logarithmic(const char* x_label, const char* y_label) {
  Panel panel;
  panel.x_label = x_label;
  panel.y_label = y_label;
  panel.log_y = true;
  return panel;
}

/// A line with a mark at each k.
void add(Panel& panel, const BoundReport& report, const char* title, int colour, Style line, const Value& x,
         const Value& y) {
  panel.series.push_back({title, line, colour, values(report, x), values(report, y), {}});
  panel.series.push_back({"", Style::kPoints, colour, values(report, x), values(report, y), {}});
}

Figure over_k(const BoundReport& report) {
  Panel noise = logarithmic("factor k on the eigenvalues", "steady error");
  Panel speed = logarithmic("factor k on the eigenvalues", "transient [s]");
  add(noise, report, "measured", kMeasured, Style::kLine, k_of, measured_error);
  add(noise, report, "measured, all noise at ±V", kOffset, Style::kThinLine, k_of,
      [](const BoundResult& r) { return r.measured.offset_max; });
  add(speed, report, "measured", kMeasured, Style::kLine, k_of, measured_s);
  const char* sharp = report.exact ? "bound, exact constants" : "bound, weights";
  for (const auto& [kind, title, colour] : {std::tuple{kSlopesBound, "bound, slopes at samples", kSlopes},
                                            {kBoxBound, "bound, domain's box", kBox},
                                            {kWeightsBound, sharp, kWeights},
                                            {kPaperBound, "bound (19)", kPaper}}) {
    if (report.exact && (kind == kSlopesBound || kind == kBoxBound)) continue;
    add(noise, report, title, colour, Style::kDashes, k_of, bounds_error(kind));
    add(speed, report, title, colour, Style::kDashes, k_of, bounds_s(kind));
  }
  Figure figure;
  figure.panel_height = 300;
  figure.panels = {std::move(noise), std::move(speed)};
  figure.caption =
      "Largest error over the second half of the runs, and the time at which the error without noise was last above a "
      "tenth of its start plus eps (left out where a bound settles above that), against the factor on all eigenvalues "
      "of D. Errors and times are on logarithmic axes.";
  return figure;
}

Figure trade_off(const BoundReport& report) {
  Panel panel = logarithmic("transient [s]", "steady error");
  add(panel, report, "measured", kMeasured, Style::kLine, measured_s, measured_error);
  add(panel, report, report.exact ? "bound, exact constants" : "bound, slopes at samples",
      report.exact ? kWeights : kSlopes, Style::kDashes, bounds_s(kSlopesBound), bounds_error(kSlopesBound));
  Figure figure;
  figure.panel_height = 340;
  figure.width = 700;
  figure.panels = {std::move(panel)};
  const BoundResult &slow = report.results.front(), &fast = report.results.back();
  figure.caption = fmt::format("The trade-off: each mark is one k, from {:.3g} to {:.3g}.", slow.k, fast.k);
  if (measured_s(fast) < measured_s(slow) && measured_error(fast) > measured_error(slow))
    figure.caption += " The fastest observer forgets its start sooner than the slowest and lets more noise through.";
  return figure;
}

}  // namespace

std::string bound_page(const BoundReport& report, const std::string& gnuplot) {
  Page page;
  page.text(fmt::format(
      "<h1>{}: how fast, how noisy</h1>\n<p class=\"soft\">Proposition 2 on the plant {}: D_k = k D; {}.</p>\n",
      escaped(report.model), escaped(report.plant), escaped(bound_conditions(report))));
  const std::vector<std::string> findings = bound_findings(report);
  page.text(fmt::format("<p class=\"summary\">{}</p>\n", escaped(findings.front())));
  page.heading("The trade-off");
  page.figure(over_k(report));
  page.figure(trade_off(report));
  page.heading("Every constant and its evidence");
  page.text(html_table(bound_table(report)));
  page.text(
      "<p class=\"soft\">Proven: exact, or nothing can exceed it. Sampled: the largest found at finitely many points. "
      "Estimated: a bound made of sampled constants, which the true one may exceed. Assumed: given on the command "
      "line. Claimed: what (19) says, whose steps are checked below.</p>\n");
  page.heading("What it comes to");
  std::string list;
  for (const std::string& finding : findings) list += fmt::format("<li>{}</li>\n", escaped(finding));
  page.text(fmt::format("<ul>\n{}</ul>\n", list));
  return html_page(report.model + " - robustness bound", page.html(gnuplot));
}

}  // namespace nlo::trainer
