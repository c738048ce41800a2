// SPDX-License-Identifier: MIT
#include "trainer/plants/logged_inputs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

constexpr double kLoggedPeriod = 0.1;

/// 0, 1, ... 40 s, a = t / 10 and b = 4 - t / 10, a row each half second.
class LoggedInputsTest : public testing::Test {
 protected:
  LoggedInputsTest() : path_(testing::TempDir() + "nlo_logged_inputs.csv") {
    std::string text = "t,a,b\n";
    for (int k = 0; k <= 80; ++k)
      text +=
          std::to_string(7.0 + 0.5 * k) + "," + std::to_string(0.05 * k) + "," + std::to_string(4.0 - 0.05 * k) + "\n";
    codegen::write_file_atomically(path_, text);
    excitation_.kinds = {InputSignal::kLog};
    excitation_.low = {0.0, 0.0};
    excitation_.high = {4.0, 4.0};
    excitation_.log = path_;
    excitation_.log_columns = {"a", "b"};
    excitation_.log_time = "t";
    simulation_.sample_period_s = kLoggedPeriod;
    simulation_.horizon_s = 10.0;
  }
  ~LoggedInputsTest() override { std::remove(path_.c_str()); }

  Eigen::MatrixXd drawn(std::uint64_t run) const {
    return draw_inputs(excitation_, simulation_, 11, run, read_logged_inputs(excitation_, simulation_));
  }
  std::string error() const {
    try {
      read_logged_inputs(excitation_, simulation_);
    } catch (const codegen::Error& caught) {
      return caught.what();
    }
    return "no error";
  }

  std::string path_;
  ExcitationConfig excitation_;
  SimulationConfig simulation_;
};

TEST_F(LoggedInputsTest, EachRunGetsAStretchFromARandomTimeOn) {
  std::set<double> starts;
  double earliest = 4.0, latest = 0.0;
  for (std::uint64_t run = 0; run < 100; ++run) {
    const Eigen::MatrixXd u = drawn(run);
    ASSERT_EQ(u.rows(), 2);
    ASSERT_EQ(u.cols(), 101);
    for (Eigen::Index k = 0; k < 101; ++k) {
      ASSERT_NEAR(u(0, k), u(0, 0) + 0.01 * static_cast<double>(k), 1e-9) << "at the run's own period";
      ASSERT_NEAR(u(0, k) + u(1, k), 4.0, 1e-9) << "both inputs are of the same time";
    }
    starts.insert(u(0, 0));
    earliest = std::min(earliest, u(0, 0));
    latest = std::max(latest, u(0, 0));
  }
  EXPECT_EQ(starts.size(), 100u);
  EXPECT_LT(earliest, 0.2);
  EXPECT_GT(latest, 2.8) << "to where the last stretch begins, 30 s";
  EXPECT_LE(latest, 3.0);
  EXPECT_EQ(drawn(7), drawn(7));
}

TEST_F(LoggedInputsTest, ARunLongerThanTheLogGoesOnAtItsBeginning) {
  simulation_.horizon_s = 100.0;
  const Eigen::MatrixXd u = drawn(0);
  int jumps = 0;
  for (Eigen::Index k = 1; k < u.cols(); ++k) jumps += u(0, k) < u(0, k - 1) ? 1 : 0;
  EXPECT_GE(jumps, 2);
  EXPECT_LE(jumps, 3);
  EXPECT_GE(u.minCoeff(), 0.0);
  EXPECT_LE(u.maxCoeff(), 4.0);
}

TEST_F(LoggedInputsTest, WithoutATimeColumnRowsAreASamplePeriodApart) {
  excitation_.log_time.clear();
  simulation_.horizon_s = 8.0;  // all of it: 81 rows
  EXPECT_NEAR(drawn(3)(0, 80), 4.0, 1e-9);
}

TEST_F(LoggedInputsTest, ErrorsNameThePlaceAndTheMend) {
  ASSERT_EQ(error(), "no error");
  excitation_.high[0] = 3.0;
  EXPECT_NE(error().find("csv:63: a is 3.05, and [excitation] lets this input go from 0 to 3; widen low and high"),
            std::string::npos)
      << error();
  excitation_.high[0] = 4.0;
  excitation_.log_time = "b";
  EXPECT_NE(error().find("csv:3: b does not increase"), std::string::npos) << error();
  excitation_.log_columns[0] = "c";
  excitation_.log_time = "t";
  EXPECT_NE(error().find("\"c\""), std::string::npos) << error();
}

TEST_F(LoggedInputsTest, AStepThatNoTimeIsDrawnBeyondIsRefused) {
  const auto said = [&](const std::string& first, const std::string& last) {
    codegen::write_file_atomically(path_, "t,a,b\n" + first + ",1,1\n" + last + ",2,2\n");
    return error();
  };
  EXPECT_EQ(said("0", "99999"), "no error") << "a million periods of .1 s, less ten";
  EXPECT_NE(said("0", "1e300").find("csv:3: t is 1e+300 s after the row before, and 1e+05 s, 1e+06 sample periods"),
            std::string::npos)
      << error();
  EXPECT_NE(said("-1e308", "1e308").find("csv:3: t is inf s after"), std::string::npos) << error();
}

TEST_F(LoggedInputsTest, OtherKindsDrawWhatTheyDrewWithoutALog) {
  ExcitationConfig steps = excitation_;
  steps.kinds = {InputSignal::kSteps};
  EXPECT_EQ(draw_inputs(steps, simulation_, 11, 5),
            draw_inputs(steps, simulation_, 11, 5, read_logged_inputs(excitation_, simulation_)));
  EXPECT_EQ(read_logged_inputs(steps, simulation_).values.size(), 0);
}

}  // namespace
}  // namespace nlo::trainer
