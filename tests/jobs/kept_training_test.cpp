// SPDX-License-Identifier: MIT
// Trainings that are kept in a folder, whatever happens to it.
#include "trainer/jobs/kept_training.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"

namespace nlo::trainer {
namespace {

const JobContext kContext{"a", 1, nullptr, [](double) {}};

TEST(KeptTraining, ADamagedCheckpointCostsItsStepsAndNotTheRun) {
  const std::string folder = std::filesystem::temp_directory_path() / ("nlo-kept-" + std::to_string(getpid()));
  std::vector<bool> resumed;
  const Train train = [&](const TrainOptions& options) {
    resumed.push_back(options.resume);
    if (options.resume) throw codegen::InputError("a damaged file");
    return TrainingResult{};
  };
  train_in(folder, kContext, train);
  EXPECT_EQ(resumed, std::vector<bool>{false}) << "there was nothing to go on from";
  std::filesystem::create_directories(folder);
  codegen::write_file_atomically(folder + "/checkpoint.bin", "damaged");
  train_in(folder, kContext, train);
  EXPECT_EQ(resumed, (std::vector<bool>{false, true, false}));
  // Control: what fails without a checkpoint fails.
  std::filesystem::remove_all(folder);
  const Train refuses = [](const TrainOptions&) -> TrainingResult { throw codegen::InputError("wrong input"); };
  EXPECT_THROW(train_in(folder, kContext, refuses), codegen::InputError);
  EXPECT_THROW(train_in("", kContext, refuses), codegen::InputError);
}

TEST(KeptTraining, HasAFolderForEachExperimentAndData) {
  std::set<std::string> folders;
  for (const FinishedRun& inputs : {FinishedRun{1, 0}, {2, 0}, {1, 2}, {12, 0}, {1, 20}})
    EXPECT_TRUE(folders.insert(kept_folder("root", inputs)).second) << inputs.experiment << " " << inputs.data;
}

}  // namespace
}  // namespace nlo::trainer
