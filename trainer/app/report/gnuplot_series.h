// SPDX-License-Identifier: MIT
// A series of points, or a map, as gnuplot reads it from a data file, and the words that say how it is drawn.
#pragma once

#include <string>

#include "trainer/app/report/gnuplot.h"

namespace nlo::trainer {

/// "#2f7de1": one of ten, over and over.
const char* palette_colour(int index);

/// Has a point that is finite.
bool drawable(const Series& series);

/// One line "x y" per point, with its width, deviation or label behind it.
std::string data_text(const Series& series);
bool has_third_column(const Series& series);

/// One line "x y value" per cell, a blank line after each row of cells, for `with image`.
std::string data_text(const HeatMap& map);

/// "with lines lw 1.8 lc rgb '#2f7de1'"
std::string style_text(const Series& series);

}  // namespace nlo::trainer
