// SPDX-License-Identifier: MIT
// `nlo reproduce` runs the program nlo-reproduce, which is installed beside nlo.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kOther = NLO_PROGRAM "-reproduce";

void expect_same(const ProgramResult& result, const ProgramResult& expected) {
  EXPECT_EQ(result.exit_code, expected.exit_code);
  EXPECT_EQ(result.out, expected.out);
  EXPECT_EQ(result.err, expected.err);
}

TEST(ReproduceCommand, PassesOnTheOutputOfItsProgram) {
  const Scratch scratch;
  const std::vector<std::string> all[] = {{"--help"},
                                          {"--version"},
                                          {},
                                          {"tabel1"},
                                          {"table1", "--quik"},
                                          {"table1", "--seeds", "0"},
                                          {"table1", "--quick", "-o", "-"},
                                          {"table1", "with space", ""}};
  std::string said;
  for (std::vector<std::string> arguments : all) {
    const ProgramResult expected = scratch.run_program(kOther, arguments);
    said += expected.out + expected.err;
    arguments.insert(arguments.begin(), "reproduce");
    expect_same(scratch.run(arguments), expected);
  }
  for (const char* words : {"Usage: nlo reproduce [OPTIONS] WHAT", "\nnlo-reproduce ", "\n  table1-control",
                            "nlo: error: tabel1: ", "did you mean \"table1\"?",
                            "did you mean \"--quick\"?; see nlo reproduce --help", "-o -: ", "with space"})
    EXPECT_THAT(said, HasSubstr(words)) << "both programs give the same output, but not the expected one";
  const ProgramResult help = scratch.run({"--help", "reproduce"});
  expect_same(help, scratch.run_program(kOther, {"--help"}));
}

TEST(ReproduceCommand, NamesTheProgramThatIsMissingAndHowToBuildIt) {
  const Scratch scratch;
  const std::string here = scratch.path();
  fs::copy_file(NLO_PROGRAM, here + "/nlo");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"reproduce", "table1", "--quick"}, {"reproduce", "--help"}}) {
    const ProgramResult missing = scratch.run_program(here + "/nlo", arguments);
    EXPECT_EQ(missing.exit_code, 2) << missing.out;
    EXPECT_THAT(missing.err, HasSubstr("nlo: error: " + fs::canonical(here).string() + "/nlo-reproduce: No such file"));
    EXPECT_THAT(missing.err, HasSubstr("cmake --build build/release --target nlo-reproduce"));
  }
  EXPECT_EQ(scratch.run_program(here + "/nlo", {"--help"}).exit_code, 0);
  EXPECT_FALSE(scratch.has("reproduction"));

  // Controls: it works if the other program is there, also through a link to nlo; a file that cannot be started is
  // named.
  fs::copy_file(kOther, here + "/nlo-reproduce");
  fs::create_directory(here + "/elsewhere");
  fs::create_symlink(here + "/nlo", here + "/elsewhere/link");
  const ProgramResult help = scratch.run({"reproduce", "--help"});
  expect_same(scratch.run_program(here + "/nlo", {"reproduce", "--help"}), help);
  expect_same(scratch.run_program(here + "/elsewhere/link", {"reproduce", "--help"}), help);
  fs::permissions(here + "/nlo-reproduce", fs::perms::owner_read);
  EXPECT_THAT(scratch.run_program(here + "/nlo", {"reproduce", "table1"}).err, HasSubstr("Permission denied"));
}

TEST(ExperimentsOfThePaper, CanBeTrainedByTheirPathButNotByName) {
  const Scratch scratch;
  const std::string paper = NLO_SOURCE_DIR "/trainer/experiments/paper/example1.toml";
  const ProgramResult by_path = scratch.run(
      {"train", paper, "-q", "-o", "run", "--set", "training.steps=1", "--set", "simulation.trajectories=2"});
  EXPECT_THAT(by_path.err, testing::Not(HasSubstr("no such file")));
  EXPECT_TRUE(scratch.has("run/model.json")) << by_path.err;
  EXPECT_THAT(scratch.refusal(2, {"train", "paper/example1"}), HasSubstr("no experiment of that name"));
}

}  // namespace
}  // namespace nlo::trainer
