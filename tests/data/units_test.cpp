// SPDX-License-Identifier: MIT
// The table of units: properties of all rows, and closed forms for rows in which errors are likely.
#include "trainer/data/units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "tests/data/data_testing.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::VectorXd;

constexpr double kUnitRounding = 4e-15;  // relative: a few roundings of double

double converted(double value, const char* from, const char* to) {
  Conversion conversion;
  EXPECT_NE(find_unit(from), nullptr) << from;
  EXPECT_NE(find_unit(to), nullptr) << to;
  EXPECT_EQ(compare_units(from, to, conversion), UnitsAre::kConvertible) << from << " " << to;
  return conversion(value);
}

TEST(Units, EveryRowIsFoundByItsNameAndNamesAreUnique) {
  std::set<std::string_view> names;
  for (const Unit& unit : unit_table()) {
    EXPECT_TRUE(names.insert(unit.name).second) << unit.name;
    EXPECT_EQ(find_unit(unit.name), &unit);
    EXPECT_GT(unit.scale, 0.0) << unit.name;
    EXPECT_TRUE(unit.offset == 0.0 || unit.kind == "temperature") << unit.name;
  }
  EXPECT_EQ(find_unit("furlong"), nullptr);
  EXPECT_EQ(find_unit(""), nullptr);
  EXPECT_EQ(find_unit("C"), nullptr);  // ambiguous: coulomb or Celsius
}

TEST(Units, EveryKindHasABaseUnit) {
  for (const Unit& unit : unit_table()) {
    bool based = false;
    for (const Unit& other : unit_table())
      based = based || (other.kind == unit.kind && other.scale == 1.0 && other.offset == 0.0);
    EXPECT_TRUE(based) << unit.kind;
  }
}

TEST(Units, ConversionsWithinAKindAreInvertibleAndConsistent) {
  constexpr double kValue = 37.25;
  int pairs = 0;
  for (const Unit& a : unit_table())
    for (const Unit& b : unit_table()) {
      if (a.kind != b.kind) continue;
      ++pairs;
      const double there = conversion(a, b)(kValue), back = conversion(b, a)(there);
      EXPECT_NEAR(back, kValue, kUnitRounding * std::abs(kValue) + kUnitRounding * std::abs(conversion(b, a).offset))
          << a.name << " " << b.name;
      // The meaning of the table: both are the same amount of the base unit.
      const double amount = a.scale * kValue + a.offset;
      EXPECT_NEAR(b.scale * there + b.offset, amount, kUnitRounding * (std::abs(amount) + b.offset))
          << a.name << " " << b.name;
      for (const Unit& c : unit_table()) {
        if (c.kind != a.kind) continue;
        const double direct = conversion(a, c)(kValue), around = conversion(b, c)(there);
        const double size = std::abs(direct) + std::abs(conversion(b, c).offset) + std::abs(conversion(a, c).offset);
        EXPECT_NEAR(around, direct, kUnitRounding * size) << a.name << " " << b.name << " " << c.name;
      }
    }
  EXPECT_GT(pairs, 1000);  // control
}

TEST(Units, RowsOfDifferentKindsNeverConvert) {
  for (const Unit& a : unit_table())
    for (const Unit& b : unit_table()) {
      Conversion conversion{2.0, 3.0};
      const UnitsAre found = compare_units(a.name, b.name, conversion);
      EXPECT_EQ(found == UnitsAre::kOfDifferentKinds, a.kind != b.kind) << a.name << " " << b.name;
      EXPECT_NE(found, UnitsAre::kUnknown);
      if (found == UnitsAre::kTheSame) {
        EXPECT_EQ(conversion.scale, 1.0) << a.name << " " << b.name;
        EXPECT_EQ(conversion.offset, 0.0) << a.name << " " << b.name;
      }
    }
}

TEST(Units, ConvertByTheirDefinitions) {
  EXPECT_NEAR(converted(180.0, "deg", "rad"), std::numbers::pi, 1e-15);
  EXPECT_NEAR(converted(60.0, "rpm", "rad/s"), 2.0 * std::numbers::pi, 1e-14);
  EXPECT_NEAR(converted(36.0, "km/h", "m/s"), 10.0, 1e-14);
  EXPECT_NEAR(converted(1013.25, "hPa", "Pa"), 101325.0, 1e-10);
  EXPECT_NEAR(converted(25.0, "degC", "K"), 298.15, 1e-12);
  EXPECT_NEAR(converted(32.0, "degF", "degC"), 0.0, 1e-12);
  EXPECT_NEAR(converted(212.0, "degF", "degC"), 100.0, 1e-12);
  EXPECT_NEAR(converted(1.0, "g", "m/s^2"), 9.80665, 1e-15);
  EXPECT_NEAR(converted(250.0, "cm", "m"), 2.5, 1e-15);
  EXPECT_NEAR(converted(1.0, "mi", "ft"), 5280.0, 1e-11);
  EXPECT_NEAR(converted(14.5037737730, "psi", "bar"), 1.0, 1e-10);
  EXPECT_NEAR(converted(2500.0, "mAh", "Ah"), 2.5, 1e-14);
  EXPECT_NEAR(converted(40.0, "%", "1"), 0.4, 1e-16);
}

TEST(Units, SpellingsOfOneUnitAreEqual) {
  Conversion conversion{2.0, 3.0};
  EXPECT_EQ(compare_units("m/s2", "m/s^2", conversion), UnitsAre::kTheSame);
  EXPECT_EQ(conversion.scale, 1.0);
  EXPECT_EQ(compare_units("\u00b0C", "degC", conversion), UnitsAre::kTheSame);
  EXPECT_EQ(compare_units("furlong", "furlong", conversion), UnitsAre::kTheSame);
  EXPECT_EQ(compare_units("", "m", conversion), UnitsAre::kTheSame);  // one of the units is unknown
  EXPECT_EQ(compare_units("furlong", "m", conversion), UnitsAre::kUnknown);
  EXPECT_EQ(compare_units("V", "m", conversion), UnitsAre::kOfDifferentKinds);
  EXPECT_EQ(with_kind("deg"), "\"deg\" (angle)");
  EXPECT_EQ(with_kind("furlong"), "\"furlong\"");
}

TEST(Units, RatesOfUnitsHaveTheUnitPerSecond) {
  for (const Unit& unit : unit_table()) {
    const std::string_view kind = kind_of_rate(unit.kind);
    if (kind.empty()) continue;
    const Unit* per_second = find_unit(std::string(unit.name) + "/s");
    if (per_second == nullptr) continue;
    EXPECT_EQ(per_second->kind, kind) << unit.name;
    EXPECT_DOUBLE_EQ(per_second->scale, unit.scale) << unit.name;
  }
  EXPECT_EQ(kind_of_rate("length"), "speed");
  EXPECT_EQ(kind_of_rate("voltage"), "");
}

constexpr double kRounding = 1e-12;  // a few units in the last place of angles up to a hundred turns

TEST(WrapDifference, LiesInTheHalfOpenTurn) {
  for (const double wrap : {kTurn, 360.0, 1.0})
    for (int i = -40; i <= 40; ++i) {
      const double difference = 0.1 * i * wrap;
      const double wrapped = wrap_difference(difference, wrap);
      EXPECT_GT(wrapped, -0.5 * wrap);
      EXPECT_LE(wrapped, 0.5 * wrap);
      EXPECT_NEAR(std::remainder(wrapped - difference, wrap), 0.0, kRounding * wrap);
    }
}

TEST(Unwrap, RecoversARotationInAnyUnit) {
  for (const double wrap : {kTurn, 360.0}) {
    const VectorXd truth = VectorXd::LinSpaced(500, 0.1 * wrap, -7.3 * wrap);
    VectorXd wrapped = truth;
    for (double& angle : wrapped) angle = wrap_difference(angle, wrap);
    EXPECT_LT((unwrap(wrapped, wrap) - truth).cwiseAbs().maxCoeff(), kRounding * wrap);
  }
}

// A pendulum that hangs at the wrap gives +pi and -pi in turn, because of noise.
TEST(Unwrap, LeavesNoJumpsIfAnAngleRestsAtTheWrap) {
  VectorXd flicker(10001);
  for (Eigen::Index k = 0; k < flicker.size(); ++k) flicker[k] = (k % 2 == 0 ? 1.0 : -1.0) * (std::numbers::pi - 1e-3);
  const VectorXd smooth = unwrap(flicker, kTurn);
  EXPECT_LT((smooth.array() - std::numbers::pi).abs().maxCoeff(), 1e-3 + kRounding);
  EXPECT_EQ(smooth[10000], flicker[10000]);  // 5,000 jumps in each direction cancel exactly
}

TEST(Unwrap, KeepsTheFirstSampleAndChannelsWithoutJumps) {
  const VectorXd smooth = VectorXd::LinSpaced(100, 20.0, 25.0);
  EXPECT_EQ(unwrap(smooth, kTurn), smooth);
  EXPECT_EQ(unwrap(VectorXd(), kTurn).size(), 0);
}

TEST(SineAndCosine, ReturnTheAngleInItsUnit) {
  const VectorXd degrees = VectorXd::LinSpaced(36, -170.0, 180.0);
  const VectorXd back = angle_of(3.0 * sine_of(degrees, 360.0), 3.0 * cosine_of(degrees, 360.0), 360.0);
  EXPECT_LT((back - degrees).cwiseAbs().maxCoeff(), 1e-11);
}

}  // namespace
}  // namespace nlo::trainer
