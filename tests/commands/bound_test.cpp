// SPDX-License-Identifier: MIT
// nlo bound as a user gives it: a learned observer that is trained again for each k, and a linear plant that is exact.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(BoundCommand, TrainsAgainForEachFactorAndSaysHowFarToTrustEachConstant) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "run", "-q"}).exit_code, 0);
  const auto bound = scratch.run({"bound", "run/model.json", "--k", "2,1", "--steps", "5", "--trajectories", "4",
                                  "--noise", "uniform:0.2", "--seed", "3", "--boxes", "200", "--json"});
  ASSERT_EQ(bound.exit_code, 0) << bound.err;
  EXPECT_THAT(bound.err, HasSubstr("training T* for k = 2"));
  const auto json = nlohmann::json::parse(bound.out);
  EXPECT_EQ(json["plant"], "van_der_pol");
  EXPECT_EQ(json["exact"], false);
  EXPECT_EQ(json["noise"], "uniform:0.2");
  EXPECT_EQ(json["seed"], 3);
  ASSERT_EQ(json["results"].size(), 2u);
  EXPECT_EQ(json["results"][0]["k"], 1.0);
  EXPECT_EQ(json["results"][0]["inverse_map"], "the model's own");
  EXPECT_EQ(json["results"][1]["inverse_map"], "retrained, 5 steps");
  for (const auto& result : json["results"]) {
    std::map<std::string, std::string> evidence;
    std::map<std::string, double> value;
    for (const auto& constant : result["constants"]) {
      evidence[constant["symbol"]] = constant["evidence"];
      EXPECT_TRUE(constant["value"].is_number() || constant["value"].is_null());
      if (constant["value"].is_number()) value[constant["symbol"]] = constant["value"];
    }
    EXPECT_EQ(evidence["l upper"], "proven");
    EXPECT_EQ(evidence["l box"], "proven");
    EXPECT_EQ(evidence["l sampled"], "sampled");
    EXPECT_LE(value["l box"], value["l upper"]);
    EXPECT_GT(value["l box"], 0.0);
    EXPECT_EQ(evidence["L_T"], "sampled");
    EXPECT_EQ(evidence["eps"], "sampled");
    EXPECT_TRUE(value.contains("l_y upper")) << "for each k, whether its T* reads y or not";
    EXPECT_EQ(evidence["w_bar"], "assumed");
    EXPECT_EQ(evidence["v_bar"], "assumed");
    for (const char* kind : {"paper_19", "weights", "box", "slopes"})
      EXPECT_GT(result["bounds"][kind]["steady"].get<double>(), 0.0) << kind;
    EXPECT_GT(result["measured"]["steady_rms"].get<double>(), 0.0);
    EXPECT_LT(result["pde_residual"].get<double>(), 1e-4);
  }
  EXPECT_EQ(json["results"][1]["constants"][0]["value"],
            2.0 * json["results"][0]["constants"][0]["value"].get<double>());
}

TEST(BoundCommand, KeepsItsTrainingsAndGoesOnWithThem) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "run", "-q"}).exit_code, 0);
  std::vector<std::string> arguments = {"bound",  "run/model.json", "--k", "1,2,4",   "--steps",
                                        "10000",  "--trajectories", "4",   "--boxes", "200",
                                        "--json", "--threads",      "1"};
  const ProgramResult whole = scratch.run(arguments);
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  arguments.insert(arguments.end(), {"-o", "out"});
  const ProgramResult stopped = scratch.run(arguments, "1/2 models");
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_THAT(stopped.err, HasSubstr("interrupted with 1 of 2 trainings left; this goes on: the same command"));
  const ProgramResult resumed = scratch.run(arguments);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(resumed.out, whole.out);
  EXPECT_THAT(resumed.err, HasSubstr("0/1 models")) << "one was found";
  arguments.insert(arguments.end(), {"--noise", "uniform:0.3"});
  EXPECT_THAT(scratch.run(arguments).err, Not(HasSubstr("training"))) << "the noise of the test trains nothing";
}

TEST(BoundCommand, SaysWhatAnAffinePlantLacks) {
  const Scratch scratch;
  scratch.write("affine.toml", with(kTinyExperiment, "model = \"van_der_pol\"",
                                    "states = [\"p\", \"v\"]\nderivative = [\"v\", \"-p - 0.2 * v + 0.1\"]\n"
                                    "output_names = [\"y\"]\noutputs = [\"p\"]"));
  ASSERT_EQ(scratch.run({"train", "affine.toml", "-o", "run", "-q"}).exit_code, 0);
  const auto bound = scratch.run({"bound", "run/model.json", "--k", "1", "--trajectories", "3", "--boxes", "20", "-q"});
  ASSERT_EQ(bound.exit_code, 0) << bound.err;
  EXPECT_THAT(bound.out, HasSubstr("linear but for offsets"));
  EXPECT_THAT(bound.out, HasSubstr("estimates, not proofs"));
  EXPECT_THAT(bound.out, Not(HasSubstr("from below")));
}

TEST(BoundCommand, IsExactOnALinearPlantAndWritesASelfContainedPage) {
  const Scratch scratch;
  scratch.write("linear.toml", with(kTinyExperiment, "van_der_pol", "harmonic_oscillator"));
  ASSERT_EQ(scratch.run({"train", "linear.toml", "-o", "run", "-q"}).exit_code, 0);
  const auto bound =
      scratch.run({"bound", "run/model.json", "--disturbance", "0.1", "--trajectories", "6", "-o", "out"});
  ASSERT_EQ(bound.exit_code, 0) << bound.err;
  EXPECT_THAT(bound.out, HasSubstr("every constant is exact, and no measurement exceeds the bound"));
  EXPECT_THAT(bound.out, HasSubstr("L_Tkx <= L_Tx / k fails for k = 2, 4, 8"));
  EXPECT_THAT(bound.out, Not(HasSubstr("sampled"))) << "nothing is";
  EXPECT_THAT(bound.err, Not(HasSubstr("training"))) << "nor is anything trained";

  const std::string page = scratch.read("out/bound.html");
  EXPECT_THAT(page, StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(page, HasSubstr("how fast, how noisy"));
  EXPECT_THAT(page, HasSubstr("proven"));
  for (const char* outside : {"src=", "<script", "<link", "@import", "url("})
    EXPECT_THAT(page, Not(HasSubstr(outside))) << "it is to be read without a network";
  EXPECT_THAT(scratch.read("out/bound.csv"), StartsWith("k,inverse_map,k_lambda,L_T,L_Tx,L_Tk,L_Tkx,l_upper,w_bar,"));
}

}  // namespace
}  // namespace nlo::trainer
