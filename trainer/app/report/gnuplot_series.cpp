// SPDX-License-Identifier: MIT
#include "trainer/app/report/gnuplot_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

namespace nlo::trainer {
namespace {

bool is_text(const Series& series) {
  return series.style == Series::Style::kTextRight || series.style == Series::Style::kTextLeft;
}

/// Returns a string for a data file, in double quotes, without double quotes and backslashes in it.
std::string data_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text)
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f && c != '\\') quoted += c == '"' ? '\'' : c;
  return quoted + '"';
}

}  // namespace

const char* palette_colour(int index) {
  // Blue, orange, green, purple, red, which differ with common colour blindness; grey; cyan, pink, brown, olive. Each
  // has a contrast of at least 3 on light and on dark background.
  static constexpr const char* kColours[] = {"#2f7de1", "#d9721a", "#1f9e77", "#9b59d0", "#d1495b",
                                             "#8a8f96", "#0e93a8", "#d55fae", "#9c6b3f", "#84901c"};
  return kColours[std::abs(index) % static_cast<int>(std::size(kColours))];
}

bool drawable(const Series& series) {
  for (Eigen::Index i = 0; i < series.x.size(); ++i)
    if (std::isfinite(series.x[i]) && std::isfinite(series.y[i])) return true;
  return false;
}

std::string data_text(const Series& series) {
  std::string text;
  for (Eigen::Index i = 0; i < series.x.size(); ++i) {
    const double x = series.x[i], y = series.y[i];
    if (!std::isfinite(x) || !std::isfinite(y)) {
      text += '\n';  // an empty line interrupts the line of the plot
      continue;
    }
    text += fmt::format("{:.6g} {:.5g}", x, y);  // finer than a pixel; more digits would only enlarge the page
    if (series.style == Series::Style::kBars) text += fmt::format(" {:.6g}", series.bar_width[i]);
    if (series.style == Series::Style::kErrorBars) text += fmt::format(" {:.5g}", series.error[i]);
    if (is_text(series)) text += " " + data_string(series.labels[static_cast<std::size_t>(i)]);
    text += '\n';
  }
  return text;
}

std::string data_text(const HeatMap& map) {
  std::string text;
  for (Eigen::Index row = 0; row < map.y.size(); ++row) {
    for (Eigen::Index column = 0; column < map.x.size(); ++column) {
      const double value = map.values(row, column);
      text += fmt::format("{:.6g} {:.6g} ", map.x[column], map.y[row]);
      text += std::isfinite(value) ? fmt::format("{:.5g}\n", std::clamp(value, map.low, map.high)) : "NaN\n";
    }
    text += '\n';
  }
  return text;
}

bool has_third_column(const Series& series) {
  return series.style == Series::Style::kBars || series.style == Series::Style::kErrorBars || is_text(series);
}

std::string style_text(const Series& series) {
  const char *style = "", *opacity = "";  // gnuplot states the transparency: 00 is opaque
  switch (series.style) {
    case Series::Style::kLine:
      style = "lines lw 1.8";
      break;
    case Series::Style::kThinLine:
      style = "lines lw 1";
      break;
    case Series::Style::kBroadLine:
      style = "lines lw 5";
      opacity = "66";
      break;
    case Series::Style::kDashes:
      style = "lines lw 1.8 dt (6,4)";
      break;
    case Series::Style::kDots:
      style = "points pt 7 ps 0.3";
      break;
    case Series::Style::kPoints:
      style = "points pt 7 ps 0.7";
      break;
    case Series::Style::kRings:
      style = "points pt 6 ps 0.7 lw 1.4";
      break;
    case Series::Style::kDiamonds:
      style = "points pt 13 ps 1.4";
      break;
    case Series::Style::kCrosses:
      style = "points pt 2 ps 1 lw 1.6";
      break;
    case Series::Style::kBars:
      style = "boxes fs solid 0.75 noborder";
      break;
    case Series::Style::kErrorBars:
      style = "yerrorbars pt 7 ps 0.7 lw 1.2";
      break;
    case Series::Style::kTextRight:
      return "with labels left offset 0.6,-0.8 font ',11'";
    case Series::Style::kTextLeft:
      return "with labels right offset -0.6,-0.8 font ',11'";
  }
  return fmt::format("with {} lc rgb '#{}{}'", style, opacity, palette_colour(series.colour) + 1);
}

}  // namespace nlo::trainer
