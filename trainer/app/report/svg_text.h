// SPDX-License-Identifier: MIT
// Shortens gnuplot's SVG for use in a page.
#pragma once

#include <string>

namespace nlo::trainer {

/// Returns the <svg> element alone. It scales with the page, black becomes the text colour of the page, and `label`
/// describes it for screen readers. Names of gnuplot and empty groups are removed, and lines have steps of a tenth of a
/// pixel. Empty if `svg` has no such element.
std::string inline_svg(std::string svg, const std::string& label = "");

/// Returns an inline_svg() as a file of its own, on white, because a page that shows it as an image gives it no
/// colours.
std::string standalone_svg(std::string svg);

/// Shortens the `d` of a path of straight lines, "M1.00,2.00 L3.00,4.00": points are rounded to a tenth of a pixel, and
/// all but the first of a line are relative to the last point. Other paths are not changed.
std::string short_path(const std::string& d);

}  // namespace nlo::trainer
