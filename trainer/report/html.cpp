// SPDX-License-Identifier: MIT
#include "trainer/report/html.h"

#include <fmt/format.h>

#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1c2127; --soft: #5d6670; --line: #d9dde2; --card: #f5f7f9; --accent: #2f7de1; --warn: #b45309; --good: #1f7a55; }
@media (prefers-color-scheme: dark) { :root { --ground: #14171b; --text: #e3e7eb; --soft: #9aa4af; --line: #333a42; --card: #1d2228; --warn: #f0a35e; --good: #57c79c; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 2.5rem 1.5rem 4rem; background: var(--ground); color: var(--text);
       font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
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
th, td { padding: .32rem .7rem; text-align: right; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-left: .2rem; }
tr.group td { font-weight: 650; padding-top: .8rem; }
tr.ours td { background: var(--card); font-weight: 600; }
figure { margin: 1.2rem 0; } figcaption { font-size: .9rem; max-width: 46rem; }
svg { display: block; width: 100%; height: auto; color: var(--text); }
figure.narrow svg { max-width: 40rem; }
.note { background: var(--card); border-left: 4px solid #e07b1f; padding: .5rem 1rem; margin: 1rem 0; }
.alarm { background: color-mix(in srgb, #d1495b 14%, transparent); border: 2px solid #d1495b; border-radius: .5rem; padding: .8rem 1rem; margin: 1.2rem 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.2rem; font-size: .9rem; margin: 0; }
dd { margin: 0; overflow-wrap: anywhere; }
dl.reports { font-size: 1rem; max-width: 54rem; margin: .8rem 0; }
code { font-size: .88em; background: var(--card); border-radius: .25rem; padding: .05rem .3rem; overflow-wrap: anywhere; }
ol.contents { columns: 2; column-gap: 2.5rem; padding-left: 1.4rem; font-size: .95rem; } li { margin: .15rem 0; }
details { margin: .4rem 0; } summary { cursor: pointer; }
table.cells th, table.cells td { white-space: nowrap; vertical-align: top; }
.paper { font-size: .82rem; color: var(--soft); } .paper b { font-weight: 600; }
td.outside { background: color-mix(in srgb, var(--warn) 12%, transparent); }
.far { color: var(--warn); font-weight: 600; } .held { color: var(--good); }
table.claims td:not(:first-child), table.claims th:not(:first-child) { white-space: nowrap; text-align: left; }
pre { background: var(--card); padding: .8rem 1rem; border-radius: .5rem; overflow-x: auto; font-size: .82rem; line-height: 1.45; }
@media print { body { max-width: none; padding: 0; font-size: 11pt; } h2 { break-after: avoid; } figure, .tiles, tr, .note, .alarm { break-inside: avoid; }
               .tile, pre, tr.ours td { background: none; border: 1px solid #d9dde2; } }
)css";

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) {  // which no page may hold either
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string html_table(const std::vector<std::string>& headings, const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"wide\"><table>\n<thead><tr>";
  for (const std::string& heading : headings) html += fmt::format("<th>{}</th>", escaped(heading));
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    if (row.size() == 1) {
      html += fmt::format("<tr class=\"group\"><td colspan=\"{}\">{}</td></tr>\n", headings.size(), escaped(row[0]));
      continue;
    }
    html += !row.empty() && row[0] == "observer" ? "<tr class=\"ours\">" : "<tr>";
    for (const std::string& cell : row) html += fmt::format("<td>{}</td>", escaped(cell));
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

}  // namespace nlo::trainer
