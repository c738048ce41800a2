// SPDX-License-Identifier: MIT
// A series of points, or a map, as a data file for gnuplot, and the style in which it is drawn.
#pragma once

#include <string>

#include "trainer/app/report/gnuplot.h"

namespace nlo::trainer {

/// Returns "#2f7de1" and so on: ten colours, repeated.
const char* palette_colour(int index);

/// Returns true if the series has a finite point.
bool drawable(const Series& series);

/// Returns one line "x y" per point, followed by its width, deviation or label.
std::string data_text(const Series& series);
bool has_third_column(const Series& series);

/// Returns one line "x y value" per cell, with a blank line after each row of cells, for `with image`.
std::string data_text(const HeatMap& map);

/// Returns "with lines lw 1.8 lc rgb '#2f7de1'".
std::string style_text(const Series& series);

}  // namespace nlo::trainer
