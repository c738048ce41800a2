// SPDX-License-Identifier: MIT
// Reads the name and the unit in the heading of a column: "height_m", "gyro x [rad/s]", "temp (degC)".
#pragma once

#include <string>
#include <vector>

#include "trainer/data/guess/column_numbers.h"

namespace nlo::trainer {

struct Heading {
  std::string name;                ///< an identifier, lower case, without the unit: "gyro_x"
  std::string unit;                ///< in the spelling of this program: "m", "rad/s", "degC"; empty: no unit
  std::vector<std::string> words;  ///< words of the name, lower case: "gyro", "x"; for "wheelSpeed": "wheel", "speed";
                                   ///< for "IMUGyro": "imu", "gyro"
};

/// Reads a heading. The unit is in brackets at the end, or is the last word after an underscore. "_a", "_g", "_n",
/// "_v", "_w", "_k" are units only if no other heading of `all` has the same beginning ("phase_a", "phase_b").
Heading read_heading(const std::string& heading, const std::vector<std::string>& all);

/// The unit of a time stamp: the unit in its heading, or else a unit with which the log has 1 to 10,000 rows per
/// second. Integers are assumed to be in a unit finer than seconds.
struct TimeUnit {
  std::string name;
  double seconds = 1.0;
  std::string why;
};
TimeUnit time_unit(const Heading& heading, const ColumnNumbers& stamps);

/// Returns true for a length or an angle, whose derivative is a velocity.
bool is_position(const std::string& unit);

}  // namespace nlo::trainer
