// SPDX-License-Identifier: MIT
// A training resumes from a checkpoint with forged bytes. The input replaces parts of a valid checkpoint after its
// heading, in pieces (offset, length, bytes), and the checksum is then corrected, so that the checkpoint must be
// refused for its content.
#include "trainer/learn/training/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "codegen/base/file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/training/train.h"

using namespace nlo;
using namespace nlo::trainer;

namespace {

struct Rig {
  Dataset training = testing::harmonics({30, 30}, false), validation = testing::harmonics({20}, false, 2);
  Experiment experiment = testing::small_experiment();
  ScratchDirectory directory;
  std::string whole;

  Rig() {
    experiment.training.steps = 6;
    experiment.training.validate_every = 2;
    experiment.training.trajectories_per_step = 2;
    experiment.training.samples_per_step = 20;
    std::atomic<bool> stop = false;
    const auto progress = [&](const TrainProgress& at) { stop = at.step >= 4; };
    (void)train(experiment, training, validation, {directory.path(), false, progress, &stop});
    whole = codegen::read_file(directory.path("checkpoint.bin"));
  }
};

/// Returns `whole` with the pieces of the input; a piece that begins beyond the end cuts the text there.
std::string forged(std::string whole, const std::uint8_t* bytes, std::size_t size) {
  constexpr std::size_t kHeading = 17 + sizeof(std::uint64_t), kSum = sizeof(std::uint64_t);
  whole.resize(whole.size() - kSum);
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t where = kHeading + (bytes[at] + 256U * bytes[at + 1]) % (whole.size() + 64 - kHeading);
    const std::size_t length = std::min<std::size_t>(bytes[at + 2] % 33U, size - at - 3);
    if (where >= whole.size()) {
      whole.resize(std::max(kHeading, whole.size() - (where - whole.size())));
    } else {
      whole.replace(where, length, reinterpret_cast<const char*>(bytes + at + 3), length);
    }
    at += 3 + length;
    if (whole.size() <= kHeading) break;
  }
  const std::uint64_t sum = fingerprint(whole.data(), whole.size());
  whole.append(reinterpret_cast<const char*>(&sum), sizeof(sum));
  return whole;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const Rig rig;
  std::ofstream(rig.directory.path("checkpoint.bin"), std::ios::binary | std::ios::trunc)
      << forged(rig.whole, bytes, size);
  fuzzing::accepts([&] {
    const TrainingResult result =
        train(rig.experiment, rig.training, rig.validation, {rig.directory.path(), true, nullptr, nullptr});
    fuzzing::require(result.outcome == TrainOutcome::kDiverged || std::isfinite(result.validation_rmse),
                     "a training that says nothing of it has a finite error");
  });
  return 0;
}
