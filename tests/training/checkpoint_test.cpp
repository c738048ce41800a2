// SPDX-License-Identifier: MIT
#include "trainer/learn/training/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/training/training_testing.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kExperiment = 0x0123456789abcdefULL;
constexpr CheckpointOwner kOwner = {
    .fingerprint = kExperiment, .parameters = 3, .memory = 6, .eigenvalues = 3, .steps = 100};

TrainingState some_state() {
  TrainingState state;
  state.step = 42;
  state.elapsed_s = 1.5;
  state.best_rmse = 0.25;
  state.returned_at = 40;
  state.parameters = {1.0F, -2.0F, 3.5F};
  state.memory = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
  state.average = {1.1F, -2.1F, 3.4F};
  state.best = {1.2F, -2.2F, 3.3F};
  for (int i = 0; i < 3; ++i) state.metrics.push_back({10 * i, 0.5 * i, 1.0, 2.0, 3.0, 1e-3, {-1.0, 2.0, -3.0}});
  return state;
}

/// Not atomic: only this test reads these files, and an fsync for each of a thousand would take seconds.
void overwrite(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

std::string message_of(const std::string& path, const CheckpointOwner& owner = kOwner) {
  try {
    (void)read_checkpoint(path, owner);
  } catch (const codegen::InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Checkpoint, ReadsBackTheBytesThatItWrote) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  const TrainingState state = some_state();
  write_checkpoint(state, kExperiment, path);
  const TrainingState back = read_checkpoint(path, kOwner);
  EXPECT_EQ(back.step, state.step);
  EXPECT_EQ(back.elapsed_s, state.elapsed_s);
  EXPECT_EQ(back.best_rmse, state.best_rmse);
  EXPECT_EQ(back.returned_at, state.returned_at);
  EXPECT_EQ(back.parameters, state.parameters);
  EXPECT_EQ(back.memory, state.memory);
  EXPECT_EQ(back.average, state.average);
  EXPECT_EQ(back.best, state.best);
  ASSERT_EQ(back.metrics.size(), state.metrics.size());
  EXPECT_EQ(back.metrics[2].step, 20);
  EXPECT_EQ(back.metrics[2].learning_rate, 1e-3);
  EXPECT_EQ(back.metrics[2].eigenvalues, state.metrics[2].eigenvalues);
}

TEST(Checkpoint, RefusesAFlippedBitInAnyByte) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  write_checkpoint(some_state(), kExperiment, path);
  const std::string whole = codegen::read_file(path);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    overwrite(path, damaged);
    const std::string message = message_of(path);
    ASSERT_THAT(message, HasSubstr(path)) << "byte " << at;
    ASSERT_THAT(message, HasSubstr("without --resume")) << "byte " << at;
  }
}

TEST(Checkpoint, RefusesTruncatedAndOtherFiles) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  write_checkpoint(some_state(), kExperiment, path);
  const std::string whole = codegen::read_file(path);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    overwrite(path, whole.substr(0, size));
    ASSERT_THAT(message_of(path), HasSubstr("without --resume")) << "size " << size;
  }
  overwrite(path, whole + '\0');
  EXPECT_THAT(message_of(path), HasSubstr("damaged"));
  overwrite(path, std::string(1000, 'x'));
  EXPECT_THAT(message_of(path), HasSubstr("not a checkpoint"));
  EXPECT_THROW((void)read_checkpoint(directory.path("absent.bin"), kOwner), codegen::Error);
}

TEST(Checkpoint, RefusesTheCheckpointOfAnotherExperiment) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  write_checkpoint(some_state(), kExperiment, path);
  CheckpointOwner other = kOwner;
  other.fingerprint += 1;
  EXPECT_THAT(message_of(path, other), HasSubstr("another experiment"));
}

/// write_checkpoint() computes the checksum of any state, so the following states are forged checkpoints.
TEST(Checkpoint, RefusesWrongSizesWithAValidChecksum) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  using Forge = void (*)(TrainingState&);
  const std::pair<const char*, Forge> forgeries[] = {
      {"no parameters", [](TrainingState& s) { s.parameters.clear(); }},
      {"one parameter more", [](TrainingState& s) { s.parameters.push_back(0.0F); }},
      {"no memory", [](TrainingState& s) { s.memory.clear(); }},
      {"memory too long", [](TrainingState& s) { s.memory.resize(1000); }},
      {"no average", [](TrainingState& s) { s.average.clear(); }},
      {"oversized average", [](TrainingState& s) { s.average.resize(1000); }},
      {"empty best", [](TrainingState& s) { s.best.clear(); }},
      {"oversized best", [](TrainingState& s) { s.best.resize(1000); }},
      {"a row with no eigenvalues", [](TrainingState& s) { s.metrics.back().eigenvalues.clear(); }},
      {"a wide first row", [](TrainingState& s) { s.metrics.front().eigenvalues.resize(100); }},
      {"a wide last row", [](TrainingState& s) { s.metrics.back().eigenvalues.resize(100); }}};
  for (const auto& [name, forge] : forgeries) {
    TrainingState state = some_state();
    forge(state);
    write_checkpoint(state, kExperiment, path);
    EXPECT_THAT(message_of(path), HasSubstr("sizes do not fit")) << name;
  }
}

TEST(Checkpoint, RefusesImpossibleNumbersWithAValidChecksum) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  using Forge = void (*)(TrainingState&);
  const std::pair<const char*, Forge> forgeries[] = {
      {"no metrics", [](TrainingState& s) { s.metrics.clear(); }},
      {"a negative step",
       [](TrainingState& s) {
         s.step = -1;
         s.metrics.resize(1);
       }},
      {"steps of -1e18", [](TrainingState& s) { s.step = -1000000000000000000; }},
      {"a row after the step", [](TrainingState& s) { s.step = 19; }},
      {"a row before all", [](TrainingState& s) { s.metrics[0].step = -1000000000000000000; }},
      {"rows out of order", [](TrainingState& s) { std::swap(s.metrics[1], s.metrics[2]); }},
      {"a row twice", [](TrainingState& s) { s.metrics[2].step = s.metrics[1].step; }},
      {"a time that is not a number", [](TrainingState& s) { s.elapsed_s = kNan; }},
      {"a negative time", [](TrainingState& s) { s.elapsed_s = -1.0; }},
      {"a row's time without end", [](TrainingState& s) { s.metrics[1].elapsed_s = kInf; }},
      {"an error that is not a number", [](TrainingState& s) { s.best_rmse = kNan; }},
      {"a return in a later step", [](TrainingState& s) { s.returned_at = s.step + 1; }},
      {"a best that is not a number", [](TrainingState& s) { s.best[1] = std::numeric_limits<float>::quiet_NaN(); }}};
  for (const auto& [name, forge] : forgeries) {
    TrainingState state = some_state();
    forge(state);
    write_checkpoint(state, kExperiment, path);
    EXPECT_THAT(message_of(path), HasSubstr("damaged")) << name;
  }
  TrainingState state = some_state();
  state.step = 1000000000000000000;
  write_checkpoint(state, kExperiment, path);
  EXPECT_THAT(message_of(path), HasSubstr("1000000000000000000 steps are done and training.steps asks for 100"));
}

TEST(Checkpoint, HasTheBestModelOfADivergedTraining) {
  const ScratchDirectory directory;
  const std::string path = directory.path("checkpoint.bin");
  TrainingState state = some_state();
  state.parameters[0] = state.memory[2] = std::numeric_limits<float>::infinity();
  write_checkpoint(state, kExperiment, path);
  EXPECT_EQ(read_checkpoint(path, kOwner).parameters, state.parameters);
}

TEST(Fingerprint, IsFnv1a) {
  EXPECT_EQ(fingerprint("", 0), 0xcbf29ce484222325ULL);
  EXPECT_EQ(fingerprint("a", 1), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(fingerprint("foobar", 6), 0x85944171f73967e8ULL);
  EXPECT_EQ(fingerprint("bar", 3, fingerprint("foo", 3)), fingerprint("foobar", 6))
      << "continues from a given fingerprint";
}

TEST(MetricsCsv, HasAColumnForEachPartOfAnEigenvalue) {
  const std::vector<MetricsRow> rows = {{7, 0.5, 1.25, 2.5, 3.0, 0.001, {-1.0, 2.0, -3.0}}};
  EXPECT_EQ(metrics_csv(rows, 1),
            "step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate,lambda_1_re,lambda_1_im,lambda_2_re,"
            "lambda_2_im\n7,0.5,1.25,2.5,3,0.001,-1,2,-3,0\n");
}

}  // namespace
}  // namespace nlo::trainer
