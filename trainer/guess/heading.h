// SPDX-License-Identifier: MIT
// What the heading of a column says: "height_m", "gyro x [rad/s]", "temp (degC)".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

struct Heading {
  std::string name;                ///< an identifier, lower case, without the unit: "gyro_x"
  std::string unit;                ///< as units are written here: "m", "rad/s", "degC"; empty: it names none
  std::vector<std::string> words;  ///< of the name, lower case: "gyro", "x"; of "wheelSpeed": "wheel", "speed"
};

/// A unit stands in brackets at the end, or is the last word behind an underscore; "_a", "_g", "_n", "_v", "_w", "_k"
/// are units only where no other heading of `all` begins as this one does ("phase_a", "phase_b").
Heading read_heading(const std::string& heading, const std::vector<std::string>& all);

}  // namespace nlo::trainer
