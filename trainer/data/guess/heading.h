// SPDX-License-Identifier: MIT
// Reads name and unit from the heading of a column: "height_m", "gyro x [rad/s]", "temp (degC)".
#pragma once

#include <string>
#include <vector>

#include "trainer/data/guess/column_numbers.h"

namespace nlo::trainer {

struct Heading {
  std::string name;                ///< an identifier, lower case, without the unit: "gyro_x"
  std::string unit;                ///< as units are written here: "m", "rad/s", "degC"; empty: it names none
  std::vector<std::string> words;  ///< words of the name, lower case: "gyro", "x"; for "wheelSpeed": "wheel", "speed";
                                   ///< for "IMUGyro": "imu", "gyro"
};

/// A unit stands in brackets at the end, or is the last word behind an underscore; "_a", "_g", "_n", "_v", "_w", "_k"
/// are units only where no other heading of `all` begins as this one does ("phase_a", "phase_b").
Heading read_heading(const std::string& heading, const std::vector<std::string>& all);

/// The unit of a stamp: its heading's unit, or one that fits its steps (a log has 1 to 10,000 rows a second; whole
/// numbers are finer units).
struct TimeUnit {
  std::string name;
  double seconds = 1.0;
  std::string why;
};
TimeUnit time_unit(const Heading& heading, const ColumnNumbers& stamps);

/// A length or an angle, whose derivative is a velocity.
bool is_position(const std::string& unit);

}  // namespace nlo::trainer
