// SPDX-License-Identifier: MIT
#include "trainer/plants/excitation.h"
#include "trainer/plants/logged_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/support/thrown_message.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

std::unique_ptr<Plant> named(const std::string& model) {
  PlantConfig config;
  config.model = model;
  return make_plant(config);
}

SimulationConfig sampled(double period_s, double horizon_s) {
  SimulationConfig config;
  config.sample_period_s = period_s;
  config.horizon_s = horizon_s;
  return config;
}

std::string error_of(const Plant& plant, const std::vector<std::string>& expressions, double time_s = 0.0) {
  return thrown_message([&] {
    const Excitation excitation = parse_excitation(plant, expressions);
    if (excitation) excitation(time_s);
  });
}

/// Returns the largest error of x1 over 2 s for x1'' = -x1 + cos 12t from rest, with x1 = (cos t - cos 12t) / 143.
double error_against_the_closed_form(double h, const Excitation& excitation) {
  const Dataset d = simulate_from(*named("harmonic_oscillator"), sampled(h, 2.0), Eigen::Vector2d::Zero(), excitation);
  const Trajectory& run = d.trajectories[0];
  const Eigen::ArrayXd x1 = (run.time_s.array().cos() - (12.0 * run.time_s.array()).cos()) / 143.0;
  return (run.states.row(0).transpose().array() - x1).abs().maxCoeff();
}

TEST(Excitation, GivesTheClosedFormOfALinearPlantAtFourthOrder) {
  const Excitation u = parse_excitation(*named("harmonic_oscillator"), {"cos(12*t)"});
  const double coarse = error_against_the_closed_form(0.02, u), fine = error_against_the_closed_form(0.01, u);
  EXPECT_LT(coarse, 1e-5);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.2);

  // Control: the same input held between samples is only of first order.
  const auto held = [](double h) -> Excitation {
    return [h](double t) { return Eigen::VectorXd::Constant(1, std::cos(12.0 * h * std::floor(t / h + 1e-6))); };
  };
  const double held_coarse = error_against_the_closed_form(0.02, held(0.02));
  EXPECT_LT(std::log2(held_coarse / error_against_the_closed_form(0.01, held(0.01))), 2.0);
  EXPECT_GT(held_coarse, 100.0 * coarse);
}

TEST(Excitation, IsRecordedAtTheSamples) {
  const auto plant = named("van_der_pol");
  const Eigen::MatrixXd initial = Eigen::MatrixXd::Random(2, 3);
  const Dataset d = simulate_from(*plant, sampled(0.1, 5.0), initial, parse_excitation(*plant, {"t^2 - 1"}));
  ASSERT_EQ(d.inputs.size(), 1u);
  EXPECT_EQ(d.inputs[0].name, "u");
  for (const Trajectory& run : d.trajectories) {
    ASSERT_EQ(run.inputs.rows(), 1);
    ASSERT_EQ(run.inputs.cols(), run.samples());
    EXPECT_LE((run.inputs.row(0).transpose().array() - run.time_s.array().square() + 1.0).abs().maxCoeff(), 1e-13);
  }
  const Dataset alone = simulate_from(*plant, sampled(0.1, 5.0), initial);
  EXPECT_TRUE(alone.inputs.empty());
  EXPECT_EQ(alone.trajectories[0].inputs.size(), 0);
  EXPECT_NE(alone.trajectories[0].states, d.trajectories[0].states);
}

TEST(Excitation, ZeroInputEqualsNoInput) {
  for (const PlantEntry& entry : plant_registry()) {
    const auto plant = named(std::string(entry.name));
    if (plant->nu() == 0) continue;
    const Eigen::MatrixXd initial = Eigen::MatrixXd::Random(plant->nx(), 2);
    const std::vector<std::string> zero(static_cast<std::size_t>(plant->nu()), "0");
    const Dataset a = simulate_from(*plant, sampled(0.02, 3.0), initial, parse_excitation(*plant, zero));
    const Dataset b = simulate_from(*plant, sampled(0.02, 3.0), initial);
    EXPECT_EQ(a.trajectories[1].states, b.trajectories[1].states) << entry.name;
  }
}

TEST(Excitation, DrivesAPlantOfExpressionsLikeTheBuiltInPlant) {
  PlantConfig config;
  config.states = {"a", "b"};
  config.derivative = {"b^3", "-a"};
  config.outputs = {"a"};
  config.inputs = {"push"};
  config.input_field = {{"0"}, {"1"}};
  const auto a = make_plant(config), b = named("reverse_duffing");
  const Eigen::Vector2d initial(0.5, -0.5);
  const auto states = [&](const Plant& plant) {
    return simulate_from(plant, sampled(0.02, 10.0), initial, parse_excitation(plant, {"cos(12*t)"}))
        .trajectories[0]
        .states;
  };
  EXPECT_LE((states(*a) - states(*b)).cwiseAbs().maxCoeff(), 1e-12);  // 500 steps of 1e-16, stable
}

TEST(Excitation, HasOneExpressionForEachInputInOrder) {
  const Eigen::Matrix2d b = Eigen::Matrix2d::Identity();
  const LinearPlant plant("pair", channels({"x1", "x2"}), channels({"y"}), Eigen::Matrix2d::Zero(),
                          Eigen::RowVector2d(1.0, 0.0), channels({"left", "right"}), b);
  const Excitation u = parse_excitation(plant, {"2*t", "sin(pi*t)"});
  EXPECT_EQ(u(0.5), Eigen::VectorXd(Eigen::Vector2d(1.0, 1.0)));
  // Integrators: x = (t^2, (1 - cos(pi t)) / pi).
  const Dataset d = simulate_from(plant, sampled(0.01, 1.0), Eigen::Vector2d::Zero(), u);
  const Eigen::Vector2d end = d.trajectories[0].states.rightCols<1>();
  EXPECT_NEAR(end(0), 1.0, 1e-14);
  EXPECT_NEAR(end(1), 2.0 / 3.141592653589793, 1e-9);  // Simpson's rule: (pi h)^4 / 2880
  EXPECT_THAT(error_of(plant, {"1"}), HasSubstr("plant pair has 2 inputs (left, right), but --input gives 1"));
  EXPECT_THAT(error_of(*named("sine_cosine"), {"1"}), HasSubstr("plant sine_cosine has no input to excite"));
  EXPECT_FALSE(parse_excitation(plant, {}));
}

TEST(Excitation, ErrorsNameTheInputTheExpressionAndThePosition) {
  const auto plant = named("van_der_pol");
  EXPECT_THAT(error_of(*plant, {"cos(12*x1)"}),
              AllOf(HasSubstr("input u \"cos(12*x1)\""), HasSubstr("position 8"), HasSubstr("variables: t")));
  EXPECT_THAT(error_of(*plant, {"cos(12*t"}), HasSubstr("input u \"cos(12*t\""));
  EXPECT_THAT(error_of(*plant, {"u = t"}), HasSubstr("an expression cannot contain \"=\""));
  EXPECT_THAT(error_of(*plant, {""}), HasSubstr("the expression is empty"));
  EXPECT_THAT(error_of(*plant, {"sqrt(1 - t)"}, 1.5), HasSubstr("is not a finite number at t = 1.5 s"));
  EXPECT_EQ(error_of(*plant, {"sqrt(1 - t)"}, 0.5), "no error");
}

constexpr double kLoggedPeriod = 0.1;

/// 0 to 40 s with a row each half second; a = t / 10 and b = 4 - t / 10.
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

TEST_F(LoggedInputsTest, EachRunGetsAPieceFromARandomTime) {
  std::set<double> starts;
  double earliest = 4.0, latest = 0.0;
  for (std::uint64_t run = 0; run < 100; ++run) {
    const Eigen::MatrixXd u = drawn(run);
    ASSERT_EQ(u.rows(), 2);
    ASSERT_EQ(u.cols(), 101);
    for (Eigen::Index k = 0; k < 101; ++k) {
      ASSERT_NEAR(u(0, k), u(0, 0) + 0.01 * static_cast<double>(k), 1e-9) << "resampled to the period of the run";
      ASSERT_NEAR(u(0, k) + u(1, k), 4.0, 1e-9) << "both inputs have the same times";
    }
    starts.insert(u(0, 0));
    earliest = std::min(earliest, u(0, 0));
    latest = std::max(latest, u(0, 0));
  }
  EXPECT_EQ(starts.size(), 100u);
  EXPECT_LT(earliest, 0.2);
  EXPECT_GT(latest, 2.8) << "up to the last possible beginning, 30 s";
  EXPECT_LE(latest, 3.0);
  EXPECT_EQ(drawn(7), drawn(7));
}

TEST_F(LoggedInputsTest, ARunLongerThanTheLogRepeatsIt) {
  simulation_.horizon_s = 100.0;
  const Eigen::MatrixXd u = drawn(0);
  int jumps = 0;
  for (Eigen::Index k = 1; k < u.cols(); ++k) jumps += u(0, k) < u(0, k - 1) ? 1 : 0;
  EXPECT_GE(jumps, 2);
  EXPECT_LE(jumps, 3);
  EXPECT_GE(u.minCoeff(), 0.0);
  EXPECT_LE(u.maxCoeff(), 4.0);
}

TEST_F(LoggedInputsTest, RowsAreASamplePeriodApartWithoutATimeColumn) {
  excitation_.log_time.clear();
  simulation_.horizon_s = 8.0;  // the whole log: 81 rows
  EXPECT_NEAR(drawn(3)(0, 80), 4.0, 1e-9);
}

TEST_F(LoggedInputsTest, ErrorsNameThePlaceAndTheRemedy) {
  ASSERT_EQ(error(), "no error");
  excitation_.high[0] = 3.0;
  EXPECT_NE(error().find("csv:63: a is 3.05, but [excitation] limits this input to 0 to 3; widen low and high"),
            std::string::npos)
      << error();
  excitation_.high[0] = 4.0;
  excitation_.log_time = "b";
  EXPECT_NE(error().find("csv:3: b does not increase"), std::string::npos) << error();
  excitation_.log_columns[0] = "c";
  excitation_.log_time = "t";
  EXPECT_NE(error().find("\"c\""), std::string::npos) << error();
}

TEST_F(LoggedInputsTest, RefusesAGapThatIsTooLong) {
  const auto said = [&](const std::string& first, const std::string& last) {
    codegen::write_file_atomically(path_, "t,a,b\n" + first + ",1,1\n" + last + ",2,2\n");
    return error();
  };
  EXPECT_EQ(said("0", "99999"), "no error") << "a million periods of .1 s, minus ten";
  EXPECT_NE(said("0", "1e300")
                .find("csv:3: t is 1e+300 s after the row before, but at most 1e+05 s (1e+06 sample "
                      "periods) are allowed"),
            std::string::npos)
      << error();
  EXPECT_NE(said("-1e308", "1e308").find("csv:3: t is inf s after"), std::string::npos) << error();
}

TEST_F(LoggedInputsTest, OtherKindsDrawTheSameNumbersWithoutALog) {
  ExcitationConfig steps = excitation_;
  steps.kinds = {InputSignal::kSteps};
  EXPECT_EQ(draw_inputs(steps, simulation_, 11, 5),
            draw_inputs(steps, simulation_, 11, 5, read_logged_inputs(excitation_, simulation_)));
  EXPECT_EQ(read_logged_inputs(steps, simulation_).values.size(), 0);
}

}  // namespace
}  // namespace nlo::trainer
