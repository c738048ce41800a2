// SPDX-License-Identifier: MIT
// Tests that the program `claims` continues after an interruption.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

TEST(Claims, ContinueAfterAnInterruptionWithTheFinishedTrainings) {
  const Scratch scratch;
  scratch.write("ledger.toml", R"toml(
[[experiment]]
id = "a"
train = "van_der_pol"
seeds = 3
set = ["training.steps=50", "simulation.trajectories=4"]

[[claim]]
id = "a.error"
experiment = "a"
run = "evaluate --trajectories 2"
metric = "/0/norm"
at_least = 0.0
)toml");
  const std::vector<std::string> arguments = {"--ledger", "ledger.toml", "--work", "work"};
  const ProgramResult stopped = scratch.run_program(NLO_CLAIMS, arguments, "a: training seed 2");
  EXPECT_EQ(stopped.exit_code, 1) << stopped.out;
  EXPECT_THAT(stopped.err, HasSubstr("1 of 1 trainings left; to continue: "));
  EXPECT_THAT(stopped.err, HasSubstr("--ledger ledger.toml --work work --resume\n"));
  EXPECT_TRUE(scratch.has("work/a_1/finished.json"));
  EXPECT_FALSE(scratch.has("work/a_3")) << "control: it was interrupted before its end";

  std::vector<std::string> more = arguments;
  more.push_back("--resume");
  const ProgramResult resumed = scratch.run_program(NLO_CLAIMS, more);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.out << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("1 figures of 1 agree with the ledger"));
  EXPECT_THAT(scratch.read("work/a_1/train.log.out"), HasSubstr("already done"));
  EXPECT_THAT(scratch.read("work/a_3/train.log.out"), testing::Not(HasSubstr("already done")));
}

}  // namespace
}  // namespace nlo::trainer
