// SPDX-License-Identifier: MIT
#include "trainer/app/report/gnuplot_script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "trainer/app/report/gnuplot_series.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

// Viridis has even steps of lightness, so it is readable in grey and with colour blindness.
constexpr const char* kHeatPalette =
    "set palette defined (0 '#440154', 1 '#472d7b', 2 '#3b528b', 3 '#2c728e', 4 '#21918c', 5 '#28ae80', 6 '#5ec962', "
    "7 '#addc30', 8 '#fde725')\n";

std::string heat_map_script(const HeatMap& map) {
  return fmt::format("{}{} colorbox\n{} logscale cb\nset cbrange [{:.6g}:{:.6g}]\nset cblabel {}\nset size ratio -1\n",
                     kHeatPalette, map.show_scale ? "set" : "unset", map.logarithmic ? "set" : "unset", map.low,
                     map.high, gnuplot_quoted(map.label));
}

/// Returns a step of 1, 2 or 5 times a power of ten that gives about `tics` tics.
double tic_step(double range, double tics) {
  const double rough = range / tics, power = std::pow(10.0, std::floor(std::log10(rough)));
  const double lead = rough / power;
  return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

/// Returns the distance of the tics of a linear axis with given ends, for about y_tics tics.
double tic_step(const Panel& panel) {
  return tic_step(panel.y_high - panel.y_low, panel.y_tics);
}

/// Returns round numbers between the ends of a logarithmic axis, because gnuplot labels only powers of ten. Empty if
/// the axis spans more than three decades, where powers of ten are enough, or if its ends are not given.
std::string log_tics(double low, double high) {
  if (!(low > 0.0) || !(high > low) || high / low > 1e3) return "";
  const std::vector<int> few = {1, 2, 5}, all = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (const std::vector<int>& leads : {few, all}) {
    std::vector<std::string> tics;
    for (double power = std::pow(10.0, std::floor(std::log10(low))); power <= high; power *= 10.0)
      for (const int lead : leads)
        if (lead * power >= low && lead * power <= high) tics.push_back(fmt::format("{:.6g}", lead * power));
    if (tics.size() > 1) return fmt::format("({})", fmt::join(tics, ", "));
  }
  return "";
}

/// Returns the characters of the longest number on the y axis of a panel with given ends; otherwise 0.
std::size_t tic_width(const Panel& panel) {
  if (!(panel.y_low < panel.y_high) || panel.log_y || !panel.y_names.empty()) return 0;
  const double step = tic_step(panel);
  std::size_t longest = 0;
  for (double tic = std::ceil(panel.y_low / step); tic * step <= panel.y_high; tic += 1.0)
    longest = std::max(longest, fmt::format("{:.6g}", tic * step).size());
  return longest;
}

std::string range_text(const char* axis, double low, double high) {
  return low == high ? fmt::format("set {}range [*:*]\n", axis)
                     : fmt::format("set {}range [{:.6g}:{:.6g}]\n", axis, low, high);
}

/// Returns "'first' 1, 'second' 2".
std::string numbered(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("{}{} {}", i > 0 ? ", " : "", gnuplot_quoted(names[i]), i + 1);
  return text;
}

/// Returns the commands of one panel, with `nothing` in place of a plot without data. Writes its data to files.
/// `written` becomes false if one of them cannot be written.
std::string panel_script(const Panel& panel, std::size_t figure, std::size_t index, const fs::path& directory,
                         bool& written, const char* nothing) {
  constexpr const char* kZero = "nohead lw 0.8 lc rgb '#8f949b'";
  std::string script = fmt::format("unset logscale\nunset arrow\nunset object\nset format x '{}'\nset format y '%g'\n",
                                   panel.x_numbers ? "%g" : "");
  if (panel.log_x) script += "set logscale x\n";
  if (panel.log_y) script += "set logscale y\n";
  script += range_text("x", panel.x_low, panel.x_high) + range_text("y", panel.y_low, panel.y_high);
  const bool scaled = panel.y_low < panel.y_high;
  std::string y_tics;
  if (!panel.y_names.empty())
    y_tics = fmt::format("({})", numbered(panel.y_names));
  else if (panel.log_y)
    y_tics = log_tics(panel.y_low, panel.y_high);
  else if (scaled)
    y_tics = fmt::format("{:.6g}", tic_step(panel));  // gnuplot's tics would overlap in a low panel
  const std::string x_tics = panel.log_x ? log_tics(panel.x_low, panel.x_high) : "";
  script += fmt::format("set grid lt 1 lw {} lc rgb '#c3c7cd' back\nset xtics {}\nset ytics {}\n",
                        panel.y_names.empty() ? 0.4 : 1.0, x_tics.empty() ? "autofreq" : x_tics,
                        y_tics.empty() ? "autofreq" : y_tics);
  script += fmt::format("set xlabel {}\nset ylabel {}\n", gnuplot_quoted(panel.x_label), gnuplot_quoted(panel.y_label));
  // Gnuplot draws an arrow even outside of the panel, so the zero line is drawn only if the axis contains zero.
  const bool has_zero = !scaled || (panel.y_low < 0.0 && panel.y_high > 0.0);
  if (panel.zero_line && has_zero)
    script += fmt::format("set arrow from graph 0, first 0 to graph 1, first 0 {}\n", kZero);
  if (panel.zero_column) script += fmt::format("set arrow from first 0, graph 0 to first 0, graph 1 {}\n", kZero);
  for (const Band& band : panel.bands)
    script += fmt::format(
        "set object rectangle from first {:.6g}, graph 0 to first {:.6g}, graph 1 behind fc rgb '{}' "
        "fs transparent solid 0.2 noborder\n",
        band.from, band.to, palette_colour(band.colour));
  script +=
      panel.title.empty() ? "unset title\n" : fmt::format("set title {} offset 0,-0.4\n", gnuplot_quoted(panel.title));
  std::string plots;
  if (panel.heat_map) {
    script += heat_map_script(*panel.heat_map);
    const std::string name = fmt::format("{}-{}-map.dat", figure, index);
    written = write_text(directory / name, data_text(*panel.heat_map)) && written;
    plots += fmt::format("plot '{}' using 1:2:3 with image pixels notitle", name);
  }
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    const Series& series = panel.series[s];
    if (!drawable(series)) continue;
    const std::string name = fmt::format("{}-{}-{}.dat", figure, index, s);
    written = write_text(directory / name, data_text(series)) && written;
    plots += fmt::format("{}'{}' using {} {} {}", plots.empty() ? "plot " : ", ", name,
                         has_third_column(series) ? "1:2:3" : "1:2", style_text(series),
                         series.title.empty() ? "notitle" : fmt::format("title {}", gnuplot_quoted(series.title)));
  }
  for (const Band& band : panel.bands)
    if (!band.title.empty() && !plots.empty())
      plots += fmt::format(", NaN with boxes lc rgb '{}' fs transparent solid 0.2 noborder title {}",
                           palette_colour(band.colour), gnuplot_quoted(band.title));
  return script + (plots.empty() ? nothing : plots + "\n");
}

/// Returns margins and gaps of a figure whose panels are on a regular grid; gnuplot needs them as shares of the whole.
/// Otherwise each panel makes room for its own labels.
std::string grid_text(const Figure& figure, std::size_t rows, std::size_t columns) {
  constexpr double kLeft = 62, kRight = 16, kTop = 62, kBottom = 72, kColumnGap = 48, kRowGap = 40;  // pixels
  constexpr double kScale = 84;  // width of a heat map's scale, with its numbers
  const bool maps = std::any_of(figure.panels.begin(), figure.panels.end(), [](const Panel& p) { return p.heat_map; });
  if (!figure.common_legend && !maps) return "";
  const double width = figure.width, height = static_cast<double>(figure.panel_height) * static_cast<double>(rows);
  const double top = figure.common_legend ? kTop : 0.5 * kTop;
  const std::string key =
      figure.common_legend ? "set key vertical maxrows 1 at screen 0.985, screen 0.995 right top\n" : "";
  return fmt::format(" margins {:.4f},{:.4f},{:.4f},{:.4f} spacing {:.4f},{:.4f}\n{}", kLeft / width,
                     1.0 - (maps ? kScale : kRight) / width, kBottom / height, 1.0 - top / height,
                     columns > 1 ? kColumnGap / width : 0.0, rows > 1 ? kRowGap / height : 0.0, key);
}

/// Draws panels below each other, each with its own height. The layouts of gnuplot have only equal heights.
std::string stack_script(const Figure& figure, std::size_t number, const fs::path& directory, bool& written) {
  double total = 0.0;
  for (const Panel& panel : figure.panels) total += panel.height;
  std::string script = "set multiplot\n";
  double top = 1.0;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const double share = figure.panels[i].height / total;
    top -= share;
    script += fmt::format("set origin 0,{:.5f}\nset size 1,{:.5f}\n", std::max(top, 0.0), share);
    script += panel_script(figure.panels[i], number, i, directory, written, "");
  }
  return script;
}

}  // namespace

std::string gnuplot_quoted(const std::string& text) {
  std::string quoted = "'";  // between single quotes only the quote itself is special
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) continue;
    if (c == '\'') quoted += '\'';
    quoted += c;
  }
  quoted += '\'';
  return quoted;
}

bool write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  return static_cast<bool>(file.flush());
}

std::string figure_script(const Figure& figure, std::size_t number, const fs::path& directory, bool& written) {
  const std::size_t count = figure.panels.size();
  const std::size_t columns = figure.side_by_side ? count : static_cast<std::size_t>(std::max(figure.columns, 1));
  const std::size_t rows = (count + columns - 1) / columns;
  const bool wide = std::any_of(figure.panels.begin(), figure.panels.end(),
                                [](const Panel& panel) { return panel.log_y; });  // tics such as 1e+06
  std::size_t margin = wide ? 12 : 9;                                             // characters
  for (const Panel& panel : figure.panels) {
    margin = std::max(margin, tic_width(panel) + 5);  // tics and the name of the axis
    for (const std::string& name : panel.y_names) margin = std::max(margin, display_width(name) + 3);
  }
  const std::string grid = grid_text(figure, rows, columns);
  const bool stacked = columns == 1 && grid.empty();
  double height = 0.0;  // in panel heights
  for (const Panel& panel : figure.panels) height += panel.height;
  if (!stacked) height = static_cast<double>(rows);
  std::string script = fmt::format(
      "reset\nset encoding utf8\nset terminal svg size {},{:.0f} font 'sans-serif,13' noenhanced\nset output '{}.svg'\n"
      "set border 3 lw 0.8\nset tics nomirror out scale 0.6\n"
      "set key outside top left horizontal Left reverse samplen 2 height 0.2\nset lmargin {}\nset rmargin 2\n",
      figure.width, figure.panel_height * height, number, margin);
  if (stacked) {
    script += stack_script(figure, number, directory, written);
  } else {
    script += fmt::format("set multiplot layout {},{}{}\n", rows, columns, grid);
    for (std::size_t i = 0; i < count; ++i)
      script += panel_script(figure.panels[i], number, i, directory, written, "set multiplot next\n");
  }
  return script + "unset multiplot\nunset output\n";
}

}  // namespace nlo::trainer
