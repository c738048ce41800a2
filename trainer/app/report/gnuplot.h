// SPDX-License-Identifier: MIT
// Draws figures as inline SVG by gnuplot in a child process. Text of users reaches gnuplot only in data files with
// fixed names and as quoted, cleaned titles in a terminal without markup.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer {

struct Series {
  enum class Style {
    kLine,
    kThinLine,
    kBroadLine,  ///< half transparent, so that lines on top stay visible
    kDashes,
    kDots,
    kPoints,
    kRings,
    kDiamonds,
    kCrosses,
    kBars,
    kErrorBars,
    kTextRight,  ///< labels to the lower right of their points
    kTextLeft
  };
  std::string title;  ///< in the legend; empty: not listed
  Style style = Style::kLine;
  int colour = 0;                        ///< index into the palette of ten, see palette_colour()
  Eigen::VectorXd x, y;                  ///< points that are not finite are left out and interrupt a line
  Eigen::VectorXd bar_width;             ///< kBars: one per point
  Eigen::VectorXd error = {};            ///< kErrorBars: points with bars from y - error to y + error
  std::vector<std::string> labels = {};  ///< kTextRight, kTextLeft: one per point
};

/// Values over a grid of points, as colours on one scale.
struct HeatMap {
  std::string label;         ///< label of the colour scale, with its unit
  Eigen::VectorXd x, y;      ///< centres of the cells, evenly spaced
  Eigen::MatrixXd values;    ///< y.size() x x.size(); a cell that is not finite is left out
  double low = 0, high = 1;  ///< ends of the scale; use equal ones in panels that are compared
  bool logarithmic = false;  ///< the scale is logarithmic
  bool show_scale = true;    ///< draw the scale beside the panel
};

/// A shaded part of the x axis, over the whole height of its panel.
struct Band {
  double from, to;
  int colour;              ///< index into the palette
  std::string title = {};  ///< in the legend; empty: not listed
};

struct Panel {
  std::string x_label, y_label;  ///< with units
  bool log_x = false, log_y = false;
  bool zero_line = false;            ///< a thin line at y = 0
  bool zero_column = false;          ///< a thin line at x = 0
  double x_low = 0.0, x_high = 0.0;  ///< axis limits; both 0: from the data
  double y_low = 0.0, y_high = 0.0;
  std::vector<Series> series;
  std::string title = {};                 ///< above the panel
  std::optional<HeatMap> heat_map = {};   ///< below the series
  std::vector<Band> bands = {};           ///< behind the series
  double height = 1.0;                    ///< height relative to a normal panel, for panels below each other
  bool x_numbers = true;                  ///< numbers at the tics; false: the panel below has them
  double y_tics = 4.0;                    ///< approximate number of tics, if y_low and y_high are given
  std::vector<std::string> y_names = {};  ///< names at y = 1, 2, ... instead of numbers
};

/// Panels below each other, or row by row on a grid.
struct Figure {
  std::string caption;  ///< text below the figure in the page
  int width = 860, panel_height = 230;
  bool side_by_side = false;  ///< all panels in one row
  std::vector<Panel> panels;
  int columns = 1;             ///< columns of the grid, unless side_by_side
  bool common_legend = false;  ///< one legend above all panels, which are on a regular grid
};

struct Drawing {
  std::vector<std::string> svgs;  ///< one per figure, for HTML; black becomes the text colour of the page
  std::string failure;            ///< reason if there are no figures; empty on success
};

/// Describes the figure in one line: "x1, error over time [s]: truth, estimate".
std::string figure_label(const Figure& figure);

/// Draws all figures with one run of `program` in a temporary directory, which is removed afterwards. Problems of
/// gnuplot do not throw: if it is missing, crashes or runs longer than 60 s, the result has a `failure`.
Drawing draw(const std::vector<Figure>& figures, const std::string& program = "gnuplot");

/// Returns `text` as a gnuplot string literal, in which no command, substitution or line break is possible.
std::string gnuplot_quoted(const std::string& text);

/// Returns at most about `points` of the values, every n-th.
Eigen::VectorXd thinned(const Eigen::VectorXd& values, Eigen::Index points = 800);

}  // namespace nlo::trainer
