// SPDX-License-Identifier: MIT
// nlo sweep as a user runs it: shells run its lines, which are killed and run again.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <sstream>
#include <string>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

/// Four jobs that train quickly.
const std::string kPlan =
    "experiment = \"tiny.toml\"\nseeds = [1, 2]\n[grid]\ninverse_map.hidden = [[4], [8]]\n[test]\ntrajectories = 5\n";

std::vector<std::string> job_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class SweepCommand : public testing::Test {
 protected:
  void SetUp() override {
    scratch.write("plans/tiny.toml", kTinyExperiment);
    scratch.write("plans/p.toml", kPlan);
  }

  /// Runs a command in a shell that finds `nlo` and returns its exit status.
  int shell(const std::string& command) const {
    const std::string program = fs::path(NLO_PROGRAM).parent_path().string();
    const std::string all = "exec >'" + scratch.path() + ".sh' 2>&1 </dev/null; cd '" + scratch.path() + "'; PATH='" +
                            program + "':\"$PATH\"; " + command;
    const int status = std::system(all.c_str());
    fs::remove(scratch.path() + ".sh");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// sweep.csv of the jobs in `folder`.
  std::string table(const std::string& folder) const {
    const ProgramResult result = scratch.ok({"sweep", "collect", "plans/p.toml", "-o", folder});
    return scratch.read(folder + "/sweep.csv");
  }

  /// Returns when each file in the scratch folder was written.
  std::map<std::string, fs::file_time_type> times() const {
    std::map<std::string, fs::file_time_type> found;
    for (const auto& entry : fs::recursive_directory_iterator(scratch.path()))
      found[entry.path().string()] = entry.last_write_time();
    return found;
  }

  Scratch scratch;
};

TEST_F(SweepCommand, WritesALineForEachJobAndNothingElse) {
  const auto before = scratch.contents();
  const ProgramResult result = scratch.ok({"sweep", "plans/p.toml", "--threads", "1"});
  const auto lines = job_lines(result.out);
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[0], StartsWith("nlo train plans/tiny.toml --set 'inverse_map.hidden=[4]' --seed 1 --threads 1 -o "
                                   "runs/p/hidden-4_seed-1_"));
  EXPECT_EQ(scratch.contents(), before);
  std::vector<std::string> parts;
  for (const char* shard : {"0/3", "1/3", "2/3"})
    for (const std::string& line :
         job_lines(scratch.run({"sweep", "plans/p.toml", "--threads", "1", "--shard", shard}).out))
      parts.push_back(line);
  EXPECT_THAT(parts, testing::UnorderedElementsAreArray(lines));
}

TEST_F(SweepCommand, AlsoVariesAShippedExperiment) {
  scratch.write("p.toml", "experiment = \"van_der_pol\"\nseeds = [1]\n");
  EXPECT_THAT(scratch.run({"sweep", "p.toml"}).out, StartsWith("nlo train van_der_pol --seed 1 -o runs/p/seed-1_"));
}

TEST_F(SweepCommand, DoesNothingForFinishedJobs) {
  scratch.ok({"sweep", "plans/p.toml", "--run"});
  const auto before = times();
  const ProgramResult again = scratch.ok({"sweep", "plans/p.toml", "--run"});
  EXPECT_THAT(again.out, HasSubstr("already done"));
  ASSERT_EQ(shell("nlo sweep plans/p.toml | sh -e"), 0);
  EXPECT_EQ(times(), before);
  // Control: two more jobs are run and do not change the other jobs.
  scratch.write("plans/p.toml", with(kPlan, "[1, 2]", "[1, 2, 3]"));
  scratch.ok({"sweep", "plans/p.toml", "--run"});
  EXPECT_EQ(times().size(), before.size() + 2 * 6) << "two folders of five files";
  const auto after = times();
  for (const auto& [file, time] : before)
    if (file.find("/runs/p/") != std::string::npos) {
      EXPECT_EQ(after.at(file), time) << file;
    }
}

TEST_F(SweepCommand, GivesTheSameTableAfterAnyNumberOfKills) {
  // Slow enough to be killed, and with many checkpoints.
  scratch.write("plans/tiny.toml", with(with(kTinyExperiment, "steps = 20", "steps = 150\ncheckpoint_every_s = 0.01"),
                                        "samples_per_step = 64", "samples_per_step = 512"));
  const auto begun = std::chrono::steady_clock::now();
  scratch.ok({"sweep", "plans/p.toml", "--run", "-o", "whole"});
  const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  const std::string whole = table("whole");
  ASSERT_THAT(job_lines(whole), SizeIs(1 + 4));
  EXPECT_THAT(whole, HasSubstr(",done,"));

  // Kill times as shares of the duration on this machine. They start small, so that the first run does not finish, and
  // grow, so that the sweep ends even if starting takes longer than training.
  std::mt19937 random(1);
  int kills = 0, unfinished = 0;
  for (int status = -1; status != 0 && kills < 200;) {
    const double part = (0.02 + 0.06 * static_cast<double>(random()) / 0x1p32) * (1.0 + 0.1 * kills);
    status = shell(fmt::format("timeout -s KILL {:.4f} nlo sweep plans/p.toml --run -o killed", part * whole_s));
    if (status == 0) break;
    ++kills;
    unfinished += table("killed").find(",unfinished,") != std::string::npos ? 1 : 0;
  }
  RecordProperty("kills", kills);
  EXPECT_GT(kills, 0) << "control: at least one job was killed";
  EXPECT_LT(kills, 200);
  EXPECT_EQ(table("killed"), whole);
  for (const auto& [file, text] : scratch.contents())
    if (file.starts_with("killed/") && file.ends_with("/model.json")) {
      EXPECT_EQ(text, scratch.read("whole" + file.substr(6))) << file;
    }
  EXPECT_GT(unfinished, 0) << "control: at least one killed job had begun and was not finished";
}

TEST_F(SweepCommand, AfterAnInterruptionNamesTheRestAndContinues) {
  scratch.write("plans/tiny.toml", with(kTinyExperiment, "steps = 20", "steps = 4000"));
  const std::vector<std::string> arguments = {"sweep", "plans/p.toml", "--run", "--threads", "1", "--shard", "0/1"};
  const ProgramResult stopped = scratch.run(arguments, "--seed 2");  // during the second of four jobs
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("of 4 trainings left; to continue: nlo sweep plans/p.toml --run --shard 0/1 "
                                     "--threads 1 -o runs/p\n"));
  EXPECT_THAT(stopped.err, testing::Not(HasSubstr("jobs failed")));
  const auto before = times();
  scratch.ok(arguments);
  const auto after = times();
  int kept = 0;
  for (const auto& [file, time] : before)
    if (file.ends_with("/finished.json")) {
      ++kept;
      EXPECT_EQ(after.at(file), time) << file;
    }
  EXPECT_GE(kept, 1);
  EXPECT_LT(kept, 4) << "control: it was stopped before its end";
}

TEST_F(SweepCommand, RefusesAFolderOfAnotherExperiment) {
  scratch.ok({"sweep", "plans/p.toml", "--run"});
  scratch.write("plans/tiny.toml", with(kTinyExperiment, "gaussian:0.1", "gaussian:0.2"));
  const auto before = times();
  const std::string result = scratch.refusal(2, {"sweep", "plans/p.toml", "--run"});
  EXPECT_THAT(result, HasSubstr("the checkpoint belongs to another experiment"));
  EXPECT_THAT(result, HasSubstr("4 of 4 jobs failed"));
  EXPECT_EQ(times(), before);
  EXPECT_THAT(table("runs/p"), HasSubstr(",other,,,,"));
}

TEST_F(SweepCommand, ContinuesAfterAJobThatFails) {
  scratch.write(
      "plans/p.toml",
      "experiment = \"tiny.toml\"\n[grid]\ntraining.learning_rate = [1e30, 0.001]\n[test]\ntrajectories = 5\n");
  for (int run = 0; run < 2; ++run) {  // the second run finds the failed job and reports it again
    EXPECT_THAT(scratch.refusal(1, {"sweep", "plans/p.toml", "--run"}), HasSubstr("1 of 2 jobs failed"));
  }
  const std::string csv = table("runs/p");
  EXPECT_THAT(csv, HasSubstr(",failed,,,,"));
  EXPECT_THAT(csv, HasSubstr(",done,"));
}

TEST_F(SweepCommand, EvaluatesObserversOfLogsOnTheirTestLogs) {
  scratch.write("plans/log.toml", kTinyLogExperiment);
  scratch.write("plans/logs/a.csv", tiny_log());
  scratch.write("plans/logs/b.csv", tiny_log(1.0));
  scratch.write("plans/p.toml", "experiment = \"log.toml\"\ndata = \"logs\"\nseeds = [1, 2]\n");
  ASSERT_EQ(shell("nlo sweep plans/p.toml | sh -e"), 0);
  EXPECT_THAT(table("runs/p"), HasSubstr(",done,"));
  const auto before = times();
  ASSERT_EQ(shell("nlo sweep plans/p.toml | sh -e"), 0);
  EXPECT_EQ(times(), before);
  scratch.write("plans/logs/a.csv", tiny_log(0.5));
  EXPECT_THAT(scratch.refusal(2, {"sweep", "plans/p.toml", "--run"}), HasSubstr("another experiment, seed or data set"))
      << "jobs on other logs are not finished";
}

TEST_F(SweepCommand, ChecksEveryJobBeforeItWritesALine) {
  const auto refusal = [&](const std::string& plan) {
    scratch.write("plans/p.toml", "experiment = \"tiny.toml\"\n" + plan);
    const ProgramResult result = scratch.run({"sweep", "plans/p.toml"});
    EXPECT_EQ(result.exit_code, 2) << plan;
    EXPECT_EQ(result.out, "");
    return result.err;
  };
  EXPECT_THAT(refusal("[grid]\ntraining.steps = [10,\n-1]\n"),
              HasSubstr("nlo: error: plans/p.toml:4: [training] steps is -1; it must be"));
  EXPECT_THAT(refusal("[grid]\ntraining.stepps = [10]\n"),
              HasSubstr("plans/p.toml:3: unknown key \"stepps\" in [training]; did you mean \"steps\"?"));
  EXPECT_THAT(refusal("[grid]\nobserver.hold = [\"rk4\"]\nobserver.eigenvalues = [[-1.0], [-60.0]]\n"),
              HasSubstr("unstable step"));
  EXPECT_THAT(refusal("[grid]\ntraining.steps = [10]\n[[point]]\ntraining.steps = 10.0\n"), HasSubstr("plans/p.toml"));
  EXPECT_THAT(refusal("[grid]\nthreads = [1, 2]\n"), HasSubstr("has the same training twice"));
  EXPECT_THAT(refusal("data = \"logs\"\n"), HasSubstr("data is only for experiments with a [log]"));
  scratch.write("plans/p.toml", "experiment = \"tinny.toml\"\n");
  EXPECT_THAT(scratch.run({"sweep", "plans/p.toml"}).err, HasSubstr("tinny.toml: no such file"));
  EXPECT_EQ(scratch.run({"sweep", "colect", "plans/p.toml"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"sweep", "collect", "plans/p.toml", "--run"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"sweep", "plans/p.toml", "--shard", "2/2"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"sweep", "plans/p.toml", "--shard", ""}).exit_code, 2)
      << "an empty shard does not mean all jobs";
}

TEST_F(SweepCommand, ExitCodeIsTwoIfAllJobsAreRefusedAndOneIfAJobFails) {
  scratch.write("plans/p.toml", "experiment = \"log.toml\"\ndata = \"nowhere\"\nseeds = [1, 2]\n");
  scratch.write("plans/log.toml", kTinyLogExperiment);
  EXPECT_THAT(scratch.refusal(2, {"sweep", "plans/p.toml", "--run"}),
              HasSubstr("2 of 2 jobs failed, all because of wrong input"));
  scratch.write("file", "");
  EXPECT_EQ(scratch.run({"sweep", "plans/p.toml", "--run", "-o", "file/x"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"sweep", "collect", "plans/p.toml", "-o", "file/x"}).exit_code, 2);
}

TEST_F(SweepCommand, GivesTheSameTableWithGnuParallel) {
  if (shell("parallel --version | grep -q 'GNU parallel'") != 0) GTEST_SKIP() << "GNU parallel is not installed";
  ASSERT_EQ(shell("nlo sweep plans/p.toml --run -o whole"), 0);
  ASSERT_EQ(shell("nlo sweep plans/p.toml --threads 1 -o by_parallel | parallel -j 2"), 0);
  EXPECT_EQ(table("by_parallel"), table("whole"));
  ASSERT_EQ(shell("nlo sweep plans/p.toml --threads 1 -o by_parallel | parallel -j 2"), 0)
      << "run again, all jobs are finished";
}

}  // namespace
}  // namespace nlo::trainer
