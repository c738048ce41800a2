// SPDX-License-Identifier: MIT
#include "trainer/app/report/svg_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "codegen/base/replaced.h"
#include "trainer/app/report/html.h"

namespace nlo::trainer {
namespace {

/// Returns tenths of a pixel as the shortest decimal: -3 is "-.3".
std::string tenths_text(long tenths) {
  const long whole = std::labs(tenths) / 10, rest = std::labs(tenths) % 10;
  std::string text = tenths < 0 ? "-" : "";
  if (whole > 0 || rest == 0) text += std::to_string(whole);
  if (rest > 0) text += "." + std::to_string(rest);
  return text;
}

/// Replaces the text in each "FROM...TO" by its `change`.
template <class Change>
std::string with_each(const std::string& text, std::string_view from, std::string_view to, Change change) {
  std::string result;
  std::size_t done = 0;
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, done)) {
    const auto begin = at + from.size(), end = text.find(to, begin);
    if (end == std::string::npos) break;
    result.append(text, done, begin - done);
    result += change(text.substr(begin, end - begin));
    done = end;
  }
  return result.append(text, done);
}

/// Removes <g ...> </g> that contain only white space; gnuplot writes one for every pen.
std::string without_empty_groups(const std::string& svg) {
  std::string result;
  std::size_t done = 0;
  for (auto at = svg.find("<g "); at != std::string::npos; at = svg.find("<g ", at + 1)) {
    const auto end = svg.find('>', at);
    const auto inside = end == std::string::npos ? end : svg.find_first_not_of(" \t\n", end + 1);
    if (inside == std::string::npos || svg.compare(inside, 4, "</g>") != 0) continue;
    result.append(svg, done, at - done);
    done = svg.find_first_not_of(" \t\n", inside + 4);
    if (done == std::string::npos) done = svg.size();
  }
  return result.append(svg, done);
}

}  // namespace

std::string short_path(const std::string& d) {
  std::string result;
  long x = 0, y = 0;
  const char *at = d.c_str(), *const end = at + d.size();
  const auto skip = [&at, end] {
    while (at < end && std::string_view(" \t\n").find(*at) != std::string_view::npos) ++at;
  };
  char drawn = 0;  // the current path command
  for (skip(); at < end; skip()) {
    const char letter = *at;
    if (letter == 'Z') {
      result += letter;
      drawn = 0;
      ++at;
      continue;
    }
    if (letter != 'M' && letter != 'L') return d;
    char* after = nullptr;
    const double px = std::strtod(at + 1, &after);
    if (after == at + 1 || *after != ',') return d;
    const char* second = after + 1;
    const double py = std::strtod(second, &after);
    if (after == second) return d;
    at = after;
    const long new_x = std::lround(10.0 * px), new_y = std::lround(10.0 * py);
    if (letter == 'M')
      result += "M" + tenths_text(new_x) + "," + tenths_text(new_y);
    else
      result += (drawn == 'L' ? " " : "l") + tenths_text(new_x - x) + "," + tenths_text(new_y - y);
    drawn = letter;
    x = new_x;
    y = new_y;
  }
  return result;
}

std::string inline_svg(std::string svg, const std::string& label) {
  const auto start = svg.find("<svg");
  if (start == std::string::npos) return "";
  svg.erase(0, start);
  const auto replace_all = [&svg](std::string_view from, std::string_view to) {
    svg = codegen::replaced(std::move(svg), from, to);
  };
  const auto cut_all = [&svg](std::string_view from, std::string_view to) {
    for (auto first = svg.find(from); first != std::string::npos; first = svg.find(from, first)) {
      const auto last = svg.find(to, first + from.size());
      if (last == std::string::npos) return;
      svg.erase(first, last + to.size() - first);
    }
  };
  cut_all("<title>Gnuplot", "</title>");
  cut_all("<title>gnuplot_plot_", "</title>");
  cut_all(" id=\"gnuplot_", "\"");  // equal in each figure of a page
  cut_all("<desc>", "</desc>");
  if (!label.empty()) svg.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", escaped(label)));
  replace_all("stroke='black'", "stroke='currentColor'");
  replace_all(" color=\"black\"", "");
  replace_all(" stroke-linecap=\"butt\" stroke-linejoin=\"miter\"", "");  // SVG has the same defaults
  replace_all("fill=\"black\"", "fill=\"currentColor\"");
  return without_empty_groups(with_each(svg, " d='", "'", short_path));
}

std::string standalone_svg(std::string svg) {
  const std::string_view none = "fill=\"none\"/>", white = "fill=\"white\"/>";  // the background rectangle
  const auto at = svg.find(none);
  if (at != std::string::npos) svg.replace(at, none.size(), white);
  return svg + "\n";
}

}  // namespace nlo::trainer
