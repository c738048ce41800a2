// SPDX-License-Identifier: MIT
#include "trainer/app/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "codegen/base/xml.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1c2127; --soft: #5d6670; --line: #d9dde2; --card: #f5f7f9; --accent: #1f66c1; --warn: #a64a06; --good: #1f7a55; --outside: #fdf1e2; --alarm: #fae9eb; }
@media (prefers-color-scheme: dark) { :root { --ground: #14171b; --text: #e3e7eb; --soft: #9aa4af; --line: #333a42; --card: #1d2228; --accent: #6ba6f0; --warn: #f0a35e; --good: #57c79c; --outside: #33261a; --alarm: #33191d; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 2.5rem 1.5rem 4rem; background: var(--ground); color: var(--text);
       font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; overflow-wrap: anywhere; margin: 0 0 .3rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .6rem; padding-top: .8rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.6rem 0 .3rem; }
a { color: var(--accent); text-decoration: none; } a:hover { text-decoration: underline; }
p { max-width: 46rem; } .soft, figcaption, dt { color: var(--soft); } .soft { font-size: .9rem; }
.summary { font-size: 1.1rem; border-left: 4px solid var(--accent); padding: .2rem 0 .2rem 1rem; margin: 1.2rem 0; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(11rem, 1fr)); gap: .8rem; margin: 1.4rem 0; }
.tile { background: var(--card); border-radius: .5rem; padding: .8rem 1rem; }
.tile b { display: block; font-size: 1.5rem; line-height: 1.25; font-variant-numeric: tabular-nums; }
.tile span { color: var(--soft); font-size: .85rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; font-variant-numeric: tabular-nums; margin: .6rem 0; }
th, td { padding: .32rem .7rem; text-align: right; border-bottom: 1px solid var(--line); vertical-align: top; }
td { white-space: nowrap; } td.text { white-space: normal; min-width: 14rem; }
th { font-weight: 600; } thead th { color: var(--soft); vertical-align: bottom; }
th:first-child, td:first-child, .text { text-align: left; } th:first-child { padding-left: .2rem; }
tbody th { font-weight: 400; white-space: nowrap; position: sticky; left: 0; background: var(--ground); }
tr.group th { font-weight: 650; padding-top: .8rem; }
tr.ours td, tr.ours th { background: var(--card); font-weight: 600; }
table.dense { font-size: .82rem; } .dense th, .dense td { padding: .25rem .45rem; }
figure { margin: 1.2rem 0; } .plot { overflow-x: auto; } figcaption { font-size: .9rem; max-width: 46rem; }
svg { display: block; width: 100%; min-width: 48rem; height: auto; color: var(--text); }
svg [stroke="rgb(195, 199, 205)"] { stroke: var(--line); }
figure.narrow svg { min-width: 30rem; max-width: 40rem; }
.note { background: var(--card); border-left: 4px solid #e07b1f; padding: .5rem 1rem; margin: 1rem 0; }
.alarm { background: var(--alarm); border: 2px solid #d1495b; border-radius: .5rem; padding: .8rem 1rem; margin: 1.2rem 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.2rem; font-size: .9rem; margin: 0; }
dd { margin: 0; overflow-wrap: anywhere; }
dl.reports { font-size: 1rem; max-width: 54rem; margin: .8rem 0; }
code { font-size: .88em; background: var(--card); border-radius: .25rem; padding: .05rem .3rem; overflow-wrap: anywhere; }
ol.contents { columns: 2 18rem; column-gap: 2.5rem; padding-left: 1.4rem; font-size: .95rem; } li { margin: .15rem 0; }
details { margin: .4rem 0; } summary { cursor: pointer; }
.paper { font-size: .82rem; color: var(--soft); } .paper b { font-weight: 600; }
td.outside { background: var(--outside); }
.far { color: var(--warn); font-weight: 600; } .held { color: var(--good); }
table.claims td:not(:first-child), table.claims th:not(:first-child) { white-space: nowrap; text-align: left; }
pre { background: var(--card); padding: .8rem 1rem; border-radius: .5rem; overflow-x: auto; font-size: .82rem; line-height: 1.45; }
@media (max-width: 40rem) { body { padding: 1.2rem 1rem 3rem; } dl { grid-template-columns: 1fr; gap: 0; } dd { margin-bottom: .5rem; }
                            tbody th { min-width: 6.5rem; max-width: 9rem; white-space: normal; overflow-wrap: break-word; } tr.group th { max-width: none; } }
@media print { svg { min-width: 0 !important; } body { max-width: none; padding: 0; font-size: 11pt; } h2 { break-after: avoid; } figure, .tiles, tr, .note, .alarm { break-inside: avoid; }
               .tile, pre, tr.ours td, tr.ours th { background: none; border: 1px solid #d9dde2; } }
)css";

/// Puts the text after a line break below, in small letters.
std::string two_lines(const std::string& cell) {
  const auto at = cell.find('\n');
  if (at == std::string::npos) return escaped(cell);
  return fmt::format("{}<div class=\"paper\">{}</div>", escaped(cell.substr(0, at)), escaped(cell.substr(at + 1)));
}

}  // namespace

std::string escaped(std::string_view text) {
  return codegen::xml_escaped(printable(text));  // unprintable characters are not allowed in a page either
}

std::string html_table(const Table& table) {
  const auto& headings = table.headings;
  const auto& rows = table.rows;
  constexpr std::size_t kLongest = 24, kDense = 8;  // characters of a number with its unit; columns
  std::vector<bool> is_text(headings.size(), false);
  for (const auto& row : rows)
    for (std::size_t c = 1; c < std::min(row.size(), headings.size()); ++c)
      is_text[c] = is_text[c] || row[c].size() > kLongest;
  const auto text_class = [&](std::size_t c) { return is_text[c] ? " class=\"text\"" : ""; };
  std::string html =
      fmt::format("<div class=\"wide\"><table{}>\n<thead><tr>", headings.size() > kDense ? " class=\"dense\"" : "");
  for (std::size_t c = 0; c < headings.size(); ++c)
    html += headings[c].empty() ? "<td></td>"
                                : fmt::format("<th scope=\"col\"{}>{}</th>", text_class(c), escaped(headings[c]));
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    if (row.empty()) continue;
    if (row.size() == 1) {
      html += fmt::format("<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{}\">{}</th></tr>\n", headings.size(),
                          escaped(row[0]));
      continue;
    }
    html += row[0] == "observer" ? "<tr class=\"ours\">" : "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c)
      html += c == 0 ? fmt::format("<th scope=\"row\">{}</th>", escaped(row[c]))
                     : fmt::format("<td{}>{}</td>", c < is_text.size() ? text_class(c) : "", two_lines(row[c]));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string note(const std::string& text) {
  return fmt::format("<div class=\"note\">{}</div>\n", escaped(text));
}

std::string alarm(const std::string& text) {
  return fmt::format("<div class=\"alarm\" role=\"alert\"><b>Warning.</b> {}</div>\n", escaped(text));
}

std::string html_page(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n"
      "<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      escaped(title), kStyle, body);
}

void Page::heading(const std::string& title) {
  text(fmt::format("<h2>{}</h2>\n", escaped(title)));
}

void Page::figure(Figure figure) {
  if (figure.panels.empty()) return;
  parts_.push_back({"", static_cast<int>(figures_.size())});
  figures_.push_back(std::move(figure));
}

std::string Page::html(const std::string& gnuplot) const {
  const Drawing drawing = draw(figures_, gnuplot);
  std::string html;
  bool told = false;
  for (const Part& part : parts_) {
    if (part.figure < 0) {
      html += part.html;
    } else if (drawing.failure.empty()) {
      const auto index = static_cast<std::size_t>(part.figure);
      html += fmt::format("<figure{}>\n<div class=\"plot\">{}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
                          figures_[index].width < 800 ? " class=\"narrow\"" : "", drawing.svgs[index],
                          escaped(figures_[index].caption));
    } else if (!told) {
      html += note(
          fmt::format("The plots are missing: {}. Install gnuplot (Debian: gnuplot-nox) and write the report again.",
                      drawing.failure));
      told = true;
    }
  }
  return html;
}

}  // namespace nlo::trainer
