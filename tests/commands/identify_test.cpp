// SPDX-License-Identifier: MIT
// A plant's parameters from logs, by the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

const std::string kPendulumFolder = NLO_SOURCE_DIR "/tests/data/pendulum";

class Identify : public testing::Test {
 protected:
  ProgramResult run(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {
        "identify", kPendulumFolder + "/identify.toml", "--data", kPendulumFolder, "-o", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scratch_.run(arguments);
  }

  Scratch scratch_;
};

TEST_F(Identify, FindsThePendulumAndFiltersAheadOfWhatKnowsNoPlant) {
  const ProgramResult result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto said = nlohmann::json::parse(result.out);
  EXPECT_EQ(said, nlohmann::json::parse(scratch_.read("out/identified.json")));
  const auto score = [&](const char* name, double truth) {  // in standard errors
    const auto& p = said["parameters"][name];
    return (p["value"].get<double>() - truth) / p["standard_error"].get<double>();
  };
  EXPECT_LT(std::abs(score("w2", 9.81 / 0.4)), 4.0);
  EXPECT_LT(std::abs(score("c", 0.3)), 4.0);
  EXPECT_GT(std::abs(score("c", 0.31)), 4.0) << "control: the errors are small";
  const auto rmse = [&](const char* estimator) {
    return said["estimators"][estimator]["rmse"]["rate"]["all"].get<double>();
  };
  for (const char* filter : {"ekf", "ukf"})
    for (const char* other : {"constant_acceleration", "static_ridge", "polynomial", "difference", "constant"})
      EXPECT_LT(rmse(filter), 0.7 * rmse(other)) << filter << " " << other;
}

TEST_F(Identify, PrintsTablesAndWritesTheSameAgain) {
  const ProgramResult first = run({"--no-filters", "--threads", "1"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("standard error"));
  EXPECT_THAT(first.out, HasSubstr("written: out/identified.json"));
  const std::string written = scratch_.read("out/identified.json");
  ASSERT_EQ(run({"--no-filters", "--threads", "3"}).exit_code, 0) << "its own result is replaced";
  EXPECT_EQ(scratch_.read("out/identified.json"), written);
}

TEST_F(Identify, DoesNotReplaceWhatAnotherWrote) {
  scratch_.write("out/identified.json", "{\"identification\": \"other\"}");
  const ProgramResult refused = run({"--no-filters"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("holds the result of another identification, other; choose another directory"));
  EXPECT_EQ(scratch_.read("out/identified.json"), "{\"identification\": \"other\"}");
  EXPECT_EQ(run({"--no-filters", "--force"}).exit_code, 0);
}

TEST_F(Identify, ErrorsNamePlaceAndMend) {
  const auto error = [&](const std::vector<std::string>& arguments) {
    const ProgramResult result = scratch_.run(arguments);
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_THAT(error({"identify", "qub"}), HasSubstr("did you mean \"qube\"?"));
  EXPECT_THAT(error({"identify"}), HasSubstr("IDENTIFICATION is required"));
  EXPECT_THAT(error({"identify", "qube", "--data", kPendulumFolder}), HasSubstr("example_csv_fin[1-6].csv"));
  EXPECT_THAT(run({"--set", "plant.parameters.w=1.0"}).err, HasSubstr("the parameter \"w\" acts nowhere"));
  scratch_.write("logs/train_1.csv", "time,angel,rate\n0,0,0\n0.1,0,0\n");
  scratch_.write("logs/test.csv", "time,angle,rate\n0,0,0\n0.1,0,0\n");
  EXPECT_THAT(error({"identify", kPendulumFolder + "/identify.toml", "--data", "logs"}),
              HasSubstr("no column \"angle\""));
  EXPECT_EQ(scratch_.run({"identify", "--help-config"}).exit_code, 0);
}

}  // namespace
}  // namespace nlo::trainer
