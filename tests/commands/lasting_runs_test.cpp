// SPDX-License-Identifier: MIT
// The folder of a run survives a second program in it, a checkpoint of another run, and unusual names.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "codegen/base/file.h"
#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Holds the lock of a folder, as another running program does.
class AtWork {
 public:
  explicit AtWork(const std::string& folder) : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    EXPECT_EQ(::flock(descriptor_, LOCK_EX | LOCK_NB), 0) << folder;
  }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
  ~AtWork() { ::close(descriptor_); }

 private:
  int descriptor_;
};

TEST(LastingRuns, ASecondTrainingInAFolderIsRefusedUntilTheFirstEnds) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q"});
  const auto before = scratch.contents();
  {
    const AtWork other(scratch.path() + "/runs/tiny");
    for (const char* how : {"--resume", "--force", "--auto"}) {
      EXPECT_THAT(scratch.refusal(2, {"train", "tiny.toml", "-q", "-o", "runs/tiny", how}),
                  AllOf(HasSubstr("runs/tiny: another nlo is using this folder"), HasSubstr("-o DIR")))
          << how;
    }
    EXPECT_EQ(scratch.run({"train", "tiny.toml", "-q", "-o", "runs/elsewhere"}).exit_code, 0);
  }
  EXPECT_EQ(scratch.run({"train", "tiny.toml", "-q", "--force"}).exit_code, 0)
      << "the lock ends with the program that holds it";
  for (const auto& [name, bytes] : before) EXPECT_TRUE(scratch.contents().count(name)) << name;
}

TEST(LastingRuns, AMonitorDoesNotReplaceAModelThatWasTrainedMeanwhile) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q"});
  const std::string file = scratch.path() + "/runs/tiny/model.json", model = codegen::read_file(file);
  std::atomic<bool> at_work{true};
  std::string last;
  std::thread other([&] {  // a training that keeps writing other models, recognisable by their blank lines
    for (std::size_t lines = 1; at_work; ++lines) {
      codegen::write_file_atomically(file, last = model + std::string(lines % 1000, '\n'));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const auto monitor = scratch.run({"monitor", "runs/tiny/model.json", "--hours", "0.05", "--runs", "0"});
  at_work = false;
  other.join();
  EXPECT_EQ(monitor.exit_code, 1);
  EXPECT_THAT(monitor.err,
              AllOf(HasSubstr("runs/tiny/model.json"), HasSubstr("has changed since"), HasSubstr("run again")));
  EXPECT_EQ(codegen::read_file(file), last);
  EXPECT_EQ(scratch.run({"monitor", "runs/tiny/model.json", "--hours", "0.05", "--runs", "0"}).exit_code, 0);
}

TEST(LastingRuns, AMonitorIsNotWrittenDuringATraining) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q"});
  const auto before = scratch.contents();
  const AtWork other(scratch.path() + "/runs/tiny");
  EXPECT_THAT(scratch.refusal(2, {"monitor", "runs/tiny/model.json", "--hours", "0.05", "--runs", "0"}),
              HasSubstr("runs/tiny: another nlo is using this folder"));
  EXPECT_EQ(scratch.contents(), before);
}

TEST(LastingRuns, ACheckpointOfAnotherExperimentIsRefusedAndKept) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q"});
  const auto before = scratch.contents();
  EXPECT_THAT(scratch.refusal(2, {"train", "tiny.toml", "-q", "--resume", "--seed", "77"}),
              AllOf(HasSubstr("checkpoint.bin"), HasSubstr("another experiment, seed or data set"),
                    HasSubstr("without --resume")));
  EXPECT_EQ(scratch.contents(), before);
}

TEST(LastingRuns, ThePrintedCommandToContinueWorksInAShell) {
  const Scratch scratch;
  const std::string file = "my rig's $(touch hit).toml";
  scratch.write(file, kTinyExperiment);
  const auto stopped = scratch.run({"train", file, "--set", "training.steps=1000000", "-o", "a b;c"}, "rmse");
  ASSERT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("nlo train 'my rig'\\''s $(touch hit).toml' --set training.steps=1000000 -o "
                                     "'a b;c' --resume\n"));
  EXPECT_FALSE(scratch.has("hit"));
}

TEST(LastingRuns, ControlCharactersInNamesDoNotReachTheTerminal) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q"});
  const std::string model = scratch.read("runs/tiny/model.json");
  const std::string hostile = "x\\u001b]0;owned\\u0007";
  const auto name = model.find("\"states\"");
  ASSERT_NE(name, std::string::npos);
  const auto at = model.find("\"name\": \"", name) + 9;
  scratch.write("runs/tiny/model.json", std::string(model).replace(at, model.find('"', at) - at, hostile));
  for (const auto& command : {std::vector<std::string>{"report", "runs/tiny"},
                              {"report", "runs/tiny", "-o", "-"},
                              {"evaluate", "runs/tiny/model.json"},
                              {"evaluate", "runs/tiny/model\x1b[31m.json"},
                              {"export", "runs/tiny/model.json", "-o", "h.h"}}) {
    const auto said = scratch.run(command);
    EXPECT_THAT(said.out + said.err, AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\x07")))) << command[0];
  }
}

}  // namespace
}  // namespace nlo::trainer
