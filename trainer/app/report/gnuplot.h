// SPDX-License-Identifier: MIT
// Figures as inline SVG, drawn by gnuplot in a child process. Text from outside reaches gnuplot only as data files with
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
    kBroadLine,  ///< half transparent, so that lines over it stay visible
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
  Eigen::VectorXd x, y;                  ///< points that are not finite are left out, and break a line
  Eigen::VectorXd bar_width;             ///< kBars: one per point
  Eigen::VectorXd error = {};            ///< kErrorBars: points with bars from y - error to y + error
  std::vector<std::string> labels = {};  ///< kTextRight, kTextLeft: one per point
};

/// Values over a grid of points, as colours on one scale.
struct HeatMap {
  std::string label;         ///< label of the colour scale, with its unit
  Eigen::VectorXd x, y;      ///< centres of the cells, evenly spaced
  Eigen::MatrixXd values;    ///< y.size() x x.size(); a cell that is not finite is left out
  double low = 0, high = 1;  ///< ends of the scale: share them between panels that are to be compared
  bool logarithmic = false;  ///< the scale
  bool show_scale = true;    ///< draw it beside the panel
};

/// A stretch of the x axis, shaded over the whole height of its panel.
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
  double x_low = 0.0, x_high = 0.0;  ///< both 0: by the data
  double y_low = 0.0, y_high = 0.0;
  std::vector<Series> series;
  std::string title = {};                 ///< above the panel
  std::optional<HeatMap> heat_map = {};   ///< below the series
  std::vector<Band> bands = {};           ///< behind the series
  double height = 1.0;                    ///< in panel heights of the figure, for panels below each other
  bool x_numbers = true;                  ///< at the tics; without, the panel below has them
  double y_tics = 4.0;                    ///< about as many, where y_low and y_high are given
  std::vector<std::string> y_names = {};  ///< at y = 1, 2, ... in place of numbers
};

/// Panels below each other, or row by row on a grid.
struct Figure {
  std::string caption;  ///< below the figure in the page; not seen by gnuplot
  int width = 860, panel_height = 230;
  bool side_by_side = false;  ///< all panels in one row
  std::vector<Panel> panels;
  int columns = 1;             ///< columns of the grid, unless side_by_side
  bool common_legend = false;  ///< one legend above all panels, which stand on a regular grid
};

struct Drawing {
  std::vector<std::string> svgs;  ///< one per figure, to be pasted into HTML; black follows the page's text colour
  std::string failure;            ///< why there are none; empty on success
};

/// Describes the figure in a line: "x1, error over time [s]: truth, estimate".
std::string figure_label(const Figure& figure);

/// Draws all figures with one run of `program` in a temporary directory that is removed afterwards. Problems
/// of gnuplot do not throw: a missing program, a crash or 60 s without an end are a `failure`.
Drawing draw(const std::vector<Figure>& figures, const std::string& program = "gnuplot");

/// `text` as a gnuplot string literal that can hold no command, substitution or line break.
std::string gnuplot_quoted(const std::string& text);

/// At most about `points` of the values, each step-th.
Eigen::VectorXd thinned(const Eigen::VectorXd& values, Eigen::Index points = 800);

}  // namespace nlo::trainer
