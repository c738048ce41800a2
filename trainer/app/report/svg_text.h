// SPDX-License-Identifier: MIT
// Shortens gnuplot's SVG for use in a page.
#pragma once

#include <string>

namespace nlo::trainer {

/// The <svg> element alone, scaling with the page, black following the page's text colour, as an image that `label`
/// describes to who does not see it; without gnuplot's own names, without groups that hold nothing, and with its lines
/// in steps of a tenth of a pixel. Empty when `svg` has no such element.
std::string inline_svg(std::string svg, const std::string& label = "");

/// An inline_svg() as a file of its own, on white: a page that shows it as an image gives it no colours.
std::string standalone_svg(std::string svg);

/// The `d` of a path of straight lines, "M1.00,2.00 L3.00,4.00": each point a tenth of a pixel exact, the second and
/// later ones of a line relative to the one before. Other paths stay as they are.
std::string short_path(const std::string& d);

}  // namespace nlo::trainer
