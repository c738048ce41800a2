// SPDX-License-Identifier: MIT
// The program under inject.c: killed, refused or out of memory at one call after the other. Whatever the call, each file
// is the old one or the new one, what went wrong is said, and the same command ends well the next time and leaves
// nothing behind. By default a part of the calls is tried, with NLO_SLOW_TESTS (./test.sh --full) every one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "tests/commands/program.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NLO_SANITIZED
#endif
#endif
#if !defined(NLO_SANITIZED) && !defined(__SANITIZE_ADDRESS__)  // which wants to be the first library itself

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using Words = std::vector<std::string>;
using Files = std::map<std::string, std::string>;

/// For the programs that are started while it lives.
class Environment {
 public:
  explicit Environment(std::map<std::string, std::string> variables) : variables_(std::move(variables)) {
    for (const auto& [name, value] : variables_) ::setenv(name.c_str(), value.c_str(), 1);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() {
    for (const auto& variable : variables_) ::unsetenv(variable.first.c_str());
  }

 private:
  std::map<std::string, std::string> variables_;
};

ProgramResult run_with(const Scratch& scratch, const Words& command, const std::string& fault) {
  const Environment environment({{"LD_PRELOAD", NLO_INJECT}, {"NLO_FAULT", fault}});
  return scratch.run(command);
}

struct Counts {
  long allocations = 0, calls = 0;
};

Counts counts_of(const Scratch& scratch, const Words& command) {
  const std::string file = scratch.path() + ".counts";
  Counts counts;
  {
    const Environment environment({{"LD_PRELOAD", NLO_INJECT}, {"NLO_FAULT_COUNT", file}});
    const ProgramResult result = scratch.run(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  std::ifstream(file) >> counts.allocations >> counts.calls;
  std::filesystem::remove(file);
  EXPECT_GT(counts.allocations, 0);
  EXPECT_GT(counts.calls, 0);
  return counts;
}

/// 1 ... count: all of them, or some twenty with the first and the last three.
std::vector<long> tried(long count, long some) {
#ifdef NLO_EVERY_FAULT
  some = count;
#endif
  std::vector<long> result;
  for (long n = 1; n <= count; ++n)
    if (n <= 3 || n > count - 3 || n * some / count != (n - 1) * some / count) result.push_back(n);
  return result;
}

/// What stands in a folder, but for times, which no two runs share.
Files comparable(Files files) {
  for (auto it = files.begin(); it != files.end();)
    it = it->first.ends_with("metrics.csv") || it->first.ends_with("report.html") ||
                 it->first.ends_with("checkpoint.bin") || it->first.ends_with("run.json")
             ? files.erase(it)
             : std::next(it);
  return files;
}

/// A command that replaces what it made before with something else.
struct Case {
  const char* name;
  std::vector<Words> before;  ///< makes the old files
  Words command;
  long calls_tried, allocations_tried;
};

void PrintTo(const Case& row, std::ostream* out) {
  *out << row.name;
}

class Fault : public testing::TestWithParam<Case> {
 protected:
  Fault() {
    scratch_.write("tiny.toml", kTinyExperiment);
    for (const Words& words : GetParam().before) {
      const ProgramResult result = scratch_.run(words);
      EXPECT_EQ(result.exit_code, 0) << result.err;
    }
    old_ = scratch_.contents();
    counts_ = counts_of(scratch_, GetParam().command);
    new_ = comparable(scratch_.contents());
    restore();
  }

  void restore() {
    for (const auto& entry : std::filesystem::directory_iterator(scratch_.path())) std::filesystem::remove_all(entry);
    for (const auto& [name, bytes] : old_)
      if (name.back() != '/') scratch_.write(name, bytes);
  }

  static bool is_temporary(const std::string& name) { return name.find(".nlo-") != std::string::npos; }

  /// Each file is whole: as before or as after.
  void expect_old_or_new(const std::string& fault) {
    const Files now = comparable(scratch_.contents());
    for (const auto& [name, bytes] : now) {
      if (is_temporary(name)) continue;
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
    EXPECT_EQ(comparable(scratch_.contents()), new_) << fault;
    restore();
  }

  const Scratch scratch_;
  Files old_, new_;
  Counts counts_;
};

TEST_P(Fault, AKillBeforeAnyCallLeavesOldOrNewAndTheNextRunMendsTheRest) {
  for (const long n : tried(counts_.calls, GetParam().calls_tried)) {
    const std::string fault = "kill:" + std::to_string(n);
    EXPECT_EQ(run_with(scratch_, GetParam().command, fault).exit_code, -1) << fault << ": was not killed";
    expect_old_or_new(fault);
    expect_recovery(fault);
  }
}

TEST_P(Fault, ACallThatFailsIsSaidAndLeavesOldOrNew) {
  const int reasons[] = {EIO, ENOSPC, EACCES};
  for (const long n : tried(counts_.calls, GetParam().calls_tried)) {
    const std::string fault = "call:" + std::to_string(n) + ":" + std::to_string(reasons[n % 3]);
    const ProgramResult result = run_with(scratch_, GetParam().command, fault);
    ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << fault << ": " << result.exit_code << result.err;
    if (result.exit_code == 1) {
      EXPECT_THAT(result.err, HasSubstr("nlo: error: ")) << fault;
      expect_old_or_new(fault);
    }
    expect_recovery(fault);
  }
}

TEST_P(Fault, AnAllocationThatFailsEndsTheProgramWithAWordAndLeavesOldOrNew) {
  for (const bool and_all_after : {false, true})
    for (const long n : tried(counts_.allocations, GetParam().allocations_tried)) {
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

const Words kTrain = {"train", "tiny.toml", "-q", "-o", "run"},
            kAgain = {"train", "tiny.toml", "-q", "--seed", "9", "-o", "again"};

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
        Case{"Monitor", {kTrain}, {"monitor", "run/model.json", "--hours", "0.05", "--runs", "0"}, 3, 2}),
    [](const testing::TestParamInfo<Case>& row) { return row.param.name; });

/// Where names cannot be exchanged a folder is replaced in two steps, and that works too.
TEST(FaultyFileSystem, WithoutExchangeOfNamesAFolderIsReplacedAllTheSame) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const Words folder = {"export", "run/model.json", "-q", "--target", "arduino", "-o", "lib"};
  ASSERT_EQ(scratch.run(kTrain).exit_code, 0);
  ASSERT_EQ(scratch.run(folder).exit_code, 0);
  const Files made = scratch.contents();
  const ProgramResult result = run_with(scratch, folder, "exchange");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(scratch.contents(), made);
}

/// The control: a write that is not atomic is seen.
TEST(FaultyFileSystem, TheInjectionReachesTheCallsAndTheAllocations) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const ProgramResult first = run_with(scratch, kTrain, "call:1:" + std::to_string(ENOSPC));
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_THAT(first.err, HasSubstr("No space left on device"));
  EXPECT_EQ(run_with(scratch, kTrain, "kill:1").exit_code, -1);
  EXPECT_THAT(run_with(scratch, kTrain, "alloc:1").err, StartsWith("nlo: error: not enough memory"));
}

}  // namespace
}  // namespace nlo::trainer
#endif
