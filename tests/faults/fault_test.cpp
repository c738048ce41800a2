// SPDX-License-Identifier: MIT
// Runs the program under inject.c, which kills it, refuses a call or an allocation, at one call after the other.
// Whichever call fails, each file is the old one or the new one, the error is reported, and the same command then
// succeeds and removes the remains. By default some of the calls are tried. With NLO_SLOW_TESTS (./test.sh --full)
// every call is tried, and fifty times as many allocations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/faults/injected.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NLO_SANITIZED
#endif
#endif
#if !defined(NLO_SANITIZED) && !defined(__SANITIZE_ADDRESS__)  // the sanitizer must be the first library itself

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
#ifdef NLO_EVERY_FAULT
constexpr bool kEveryCall = true;
constexpr long kTimesAsManyAllocations = 50;  // all of the million allocations would take days
#else
constexpr bool kEveryCall = false;
constexpr long kTimesAsManyAllocations = 1;
#endif

/// A command that replaces its earlier results by different ones.
struct Case {
  const char* name;
  std::vector<Words> before;  ///< commands that make the old files
  Words command;
  long calls_tried, allocations_tried;
  bool repeats = true;  ///< true: gives the same result each time; a search with a time limit does not
  bool quick = true;    ///< true: quick enough to try every call
};

void PrintTo(const Case& row, std::ostream* out) {
  *out << row.name;
}

class Fault : public testing::TestWithParam<Case> {
 protected:
  std::vector<long> calls() const {
    return tried(counts_.calls, kEveryCall && GetParam().quick ? counts_.calls : GetParam().calls_tried);
  }
  std::vector<long> allocations() const {
    return tried(counts_.allocations, kTimesAsManyAllocations * GetParam().allocations_tried);
  }

  Fault() {
    scratch_.write("tiny.toml", kTinyExperiment);
    scratch_.write("tiny_log.toml", kTinyLogExperiment);
    scratch_.write("logs/a.csv", tiny_log());
    scratch_.write("logs/b.csv", tiny_log(1.0));
    scratch_.write("plan.toml", "experiment = \"tiny.toml\"\n[grid]\ninverse_map.hidden = [[4], [8]]\n");
    for (const Words& words : GetParam().before) {
      scratch_.ok(words);
    }
    files_ = scratch_.contents();
    old_ = comparable(files_);
    counts_ = counts_of(scratch_, GetParam().command);
    EXPECT_GT(counts_.calls, 0);
    new_ = comparable(scratch_.contents());
    restore();
  }

  void restore() {
    for (const auto& entry : std::filesystem::directory_iterator(scratch_.path())) std::filesystem::remove_all(entry);
    for (const auto& [name, bytes] : files_)
      if (name.back() != '/') scratch_.write(name, bytes);
  }

  /// Expects that each file is complete: the old one or the new one.
  void expect_old_or_new(const std::string& fault) {
    const Files now = comparable(scratch_.contents());
    for (const auto& [name, bytes] : now) {
      if (!GetParam().repeats) break;
      const auto before = old_.find(name), after = new_.find(name);
      EXPECT_TRUE((before != old_.end() && bytes == before->second) || (after != new_.end() && bytes == after->second))
          << fault << ": " << name << " is neither the old one nor the new one (" << bytes.size() << " bytes)";
    }
    for (const auto& file : old_)
      if (new_.count(file.first)) {
        EXPECT_TRUE(now.count(file.first)) << fault << ": " << file.first << " is gone";
      }
  }

  void expect_recovery(const std::string& fault) {
    const ProgramResult again = scratch_.run(GetParam().command);
    EXPECT_EQ(again.exit_code, 0) << fault << ": " << again.err;
    expect_new(fault);
    EXPECT_FALSE(leaves_temporaries()) << fault << ": the next run does not remove the temporaries of the killed run";
    restore();
  }

  void expect_new(const std::string& fault) {
    if (GetParam().repeats) {
      EXPECT_EQ(comparable(scratch_.contents()), new_) << fault;
    }
  }

  bool leaves_temporaries() const {
    const Files now = scratch_.contents();
    return std::any_of(now.begin(), now.end(), [](const auto& file) { return is_temporary(file.first); });
  }

  const Scratch scratch_;
  Files files_, old_, new_;
  Counts counts_;
};

TEST_P(Fault, AKillBeforeAnyCallLeavesOldOrNewFilesAndTheNextRunCompletes) {
  for (const long n : calls()) {
    const std::string fault = "kill:" + std::to_string(n);
    EXPECT_EQ(run_with(scratch_, GetParam().command, fault).exit_code, -1) << fault << ": was not killed";
    expect_old_or_new(fault);
    expect_recovery(fault);
  }
}

TEST_P(Fault, AFailedCallIsReportedAndLeavesOldOrNewFiles) {
  const int reasons[] = {EIO, ENOSPC, EACCES};
  for (const long n : calls()) {
    const std::string fault = "call:" + std::to_string(n) + ":" + std::to_string(reasons[n % 3]);
    const ProgramResult result = run_with(scratch_, GetParam().command, fault);
    ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << fault << ": " << result.exit_code << result.err;
    if (result.exit_code == 1) {
      EXPECT_THAT(result.err, HasSubstr("nlo: error: ")) << fault;
      expect_old_or_new(fault);
    } else {
      expect_new(fault + ", of which nothing was said: " + result.err);
    }
    if (!removes(result.err)) {
      EXPECT_FALSE(leaves_temporaries()) << fault << ": " << result.err;
    }
    expect_recovery(fault);
  }
}

TEST_P(Fault, AFailedAllocationIsReportedAndLeavesOldOrNewFiles) {
  for (const bool and_all_after : {false, true})
    for (const long n : allocations()) {
      const std::string fault = "alloc:" + std::to_string(n) + (and_all_after ? "+" : "");
      const ProgramResult result = run_with(scratch_, GetParam().command, fault);
      ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << fault << ": " << result.exit_code << result.err;
      if (result.exit_code == 1) {
        EXPECT_THAT(result.err, HasSubstr("nlo: error: not enough memory")) << fault;
      }
      expect_old_or_new(fault);
      restore();
    }
}

const std::string kPendulum = NLO_SOURCE_DIR "/tests/data/pendulum";
const Words kTrain = {"train", "tiny.toml", "-q", "-o", "run"},
            kAgain = {"train", "tiny.toml", "-q", "--seed", "9", "-o", "again"},
            kTrainOnLogs = {"train", "tiny_log.toml", "--data", "logs", "-q", "-o", "logged"},
            kSweep = {"sweep", "plan.toml", "--run", "--threads", "1"},
            kCrossvalidate = {"crossvalidate", "tiny_log.toml", "--data", "logs", "--threads", "1", "-o", "folds"};

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}
const Words kEvaluate = {"evaluate", "logged/model.json", "--figure", "f.svg", "--estimates", "e.csv", "--data"},
            kIdentify = {"identify", kPendulum + "/identify.toml", "--data", kPendulum, "--no-filters", "-o", "found"},
            kCompare = {"evaluate", "run/model.json", "--against", "ekf",         "--as-trained", "--seeds",
                        "1",        "--trajectories", "1",         "--no-tuning", "-o",           "compared"};

INSTANTIATE_TEST_SUITE_P(
    All, Fault,
    testing::Values(
        Case{"Train", {kTrain}, {"train", "tiny.toml", "-q", "--seed", "9", "--force", "-o", "run"}, 6, 3},
        Case{"Export",
             {kTrain, kAgain, {"export", "run/model.json", "-q", "-o", "h.h"}},
             {"export", "again/model.json", "-q", "-o", "h.h"},
             6,
             6},
        Case{"ExportOfTwoFiles",
             {kTrain, kAgain, {"export", "run/model.json", "-q", "--target", "c99", "--name", "h", "-o", "h.h"}},
             {"export", "again/model.json", "-q", "--target", "c99", "--name", "h", "-o", "h.h"},
             4,
             3},
        Case{"ExportOfAFolder",
             {kTrain, kAgain, {"export", "run/model.json", "-q", "--target", "arduino", "-o", "lib"}},
             {"export", "again/model.json", "-q", "--target", "arduino", "-o", "lib"},
             10,
             3},
        Case{"Report", {kTrain}, {"report", "run"}, 3, 2},
        Case{"Monitor", {kTrain}, {"monitor", "run/model.json", "--hours", "0.05", "--runs", "0"}, 3, 2},
        Case{"TrainWithMoreSteps", {kTrain}, with(kTrain, {"--resume", "--set", "training.steps=30"}), 2, 1},
        Case{"TrainOnLogs", {kTrainOnLogs}, with(kTrainOnLogs, {"--seed", "9", "--force"}), 1, 1},
        Case{"New", {{"new", "plant", "-o", "p.toml"}}, {"new", "log", "logs/a.csv", "--force", "-o", "p.toml"}, 2, 1},
        Case{"Simulate",
             {{"simulate", "tiny.toml", "-o", "s.csv", "--trajectories", "2"}},
             {"simulate", "tiny.toml", "-o", "s.csv", "--trajectories", "2", "--seed", "9"},
             2,
             1},
        Case{"Evaluate", {kTrainOnLogs, with(kEvaluate, {"logs/a.csv"})}, with(kEvaluate, {"logs/b.csv"}), 2, 1},
        Case{"Identify", {kIdentify}, with(kIdentify, {"--force", "--set", "log.every=2"}), 2, 1},
        Case{"Compare", {kTrain, kCompare}, with(kCompare, {"--seed", "9"}), 1, 1}, Case{"Sweep", {}, kSweep, 1, 1},
        Case{"Crossvalidate", {kCrossvalidate}, with(kCrossvalidate, {"--seed", "9"}), 2, 1},
        Case{"SweepCollect", {kSweep}, {"sweep", "collect", "plan.toml"}, 1, 1}),
    [](const testing::TestParamInfo<Case>& row) { return row.param.name; });

/// If the system cannot exchange two names, a folder is replaced in two steps.
TEST(FaultyFileSystem, AFolderIsAlsoReplacedWithoutAnExchangeOfNames) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const Words folder = {"export", "run/model.json", "-q", "--target", "arduino", "-o", "lib"};
  scratch.ok(kTrain);
  scratch.ok(folder);
  const Files made = scratch.contents();
  const ProgramResult result = run_with(scratch, folder, "exchange");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(scratch.contents(), made);
}

/// Control: the test detects a write that is not atomic.
TEST(FaultyFileSystem, InjectedFaultsReachTheCallsAndTheAllocations) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const ProgramResult first = run_with(scratch, kTrain, "call:1:" + std::to_string(ENOSPC));
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_THAT(first.err, HasSubstr("No space left on device"));
  EXPECT_EQ(run_with(scratch, kTrain, "kill:1").exit_code, -1);
  EXPECT_THAT(run_with(scratch, kTrain, "alloc:1").err, StartsWith("nlo: error: not enough memory"));
}

#ifdef NLO_EVERY_FAULT  // these runs take seconds each, so they are only tried exhaustively
INSTANTIATE_TEST_SUITE_P(
    Slow, Fault,
    testing::Values(
        Case{"TrainAuto", {}, {"train", "tiny.toml", "--auto", "--minutes", "1", "-o", "run"}, 9, 1, false, false},
        Case{"Reproduce",
             {{"reproduce", "example1", "--quick", "-o", "tables"}},
             {"reproduce", "example1", "--quick", "--seeds", "2", "-o", "tables"},
             9,
             1,
             true,
             false}),
    [](const testing::TestParamInfo<Case>& row) { return row.param.name; });
#endif

TEST(Faultless, CommandsThatOnlyPrintChangeNoFile) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.write("tiny_log.toml", kTinyLogExperiment);
  scratch.write("logs/a.csv", tiny_log());
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.ok(kTrain);
  const Files before = scratch.contents();
  const Words commands[] = {
      {"crossvalidate", "tiny_log.toml", "--data", "logs"},
      {"evaluate", "run/model.json", "--trajectories", "2"},
      {"evaluate", "run/model.json", "--quick", "--trajectories", "1", "--as-trained", "--no-tuning"},
      {"certify", "run/model.json", "--boxes", "20"}};
  for (const Words& command : commands) {
    EXPECT_EQ(counts_of(scratch, command).calls, 0) << command.front();
    EXPECT_EQ(scratch.contents(), before) << command.front();
  }
}

}  // namespace
}  // namespace nlo::trainer
#endif
