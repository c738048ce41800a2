// SPDX-License-Identifier: MIT
#include "trainer/guess/heading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/identifier.h"

namespace nlo::trainer {
namespace {

struct Row {
  const char *heading, *name, *unit;
};

TEST(Heading, TellsNameAndUnitApart) {
  for (const Row& row : std::vector<Row>{{"height_m", "height", "m"},
                                         {"gyro x [rad/s]", "gyro_x", "rad/s"},
                                         {"temp (degC)", "temp", "degC"},
                                         {"Temp (°C)", "temp", "degC"},
                                         {"baro_hpa", "baro", "hPa"},
                                         {"wheelSpeed_m_s", "wheel_speed", "m/s"},
                                         {"acc_mps2", "acc", "m/s^2"},
                                         {"omega_dps", "omega", "deg/s"},
                                         {"current_a", "current", "A"},
                                         {"thrust %", "thrust", ""},
                                         {"thrust_pct", "thrust", "%"},
                                         {"time_ms", "time", "ms"},
                                         {"angle", "angle", ""},
                                         {"m", "m", ""},
                                         {"x (-)", "x", ""}}) {
    const Heading heading = read_heading(row.heading, {row.heading});
    EXPECT_EQ(heading.name, row.name) << row.heading;
    EXPECT_EQ(heading.unit, row.unit) << row.heading;
  }
}

TEST(Heading, TakesALetterOfASeriesForNoUnit) {
  EXPECT_EQ(read_heading("phase_a", {"phase_a", "phase_b"}).unit, "");
  EXPECT_EQ(read_heading("phase_a", {"phase_a", "phase_b"}).name, "phase_a");
  EXPECT_EQ(read_heading("phase_a", {"phase_a"}).unit, "A");
}

TEST(Heading, MakesAnIdentifierOfAnything) {
  for (const char* heading : {"", "2nd sensor", "while", "größe", "__", "a  -  b", "[m]", "class_m"})
    EXPECT_TRUE(codegen::is_identifier(read_heading(heading, {heading}).name))
        << heading << ": " << read_heading(heading, {heading}).name;
}

}  // namespace
}  // namespace nlo::trainer
