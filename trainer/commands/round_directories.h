// SPDX-License-Identifier: MIT
// Where the rounds of [feedback] keep their checkpoints: the last one where a run without rounds does, those before it
// in round_0, round_1, ... beside it. A finished round is gone through from its checkpoint again when a run is resumed.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "trainer/config/experiment.h"
#include "trainer/training/checkpoint.h"

namespace nlo::trainer {

class RoundDirectories {
 public:
  RoundDirectories(std::string output, const Experiment& experiment)
      : output_(std::move(output)), last_(experiment.feedback ? experiment.feedback->rounds : 0) {}

  int last() const { return last_; }

  std::string of(int round) const { return round == last_ ? output_ : output_ + "/round_" + std::to_string(round); }

  /// Whether a round has a checkpoint.
  bool begun(int round) const { return has_checkpoint(of(round)); }

  /// Removes checkpoints of another run, which a resumed one would take for its own.
  void forget() const {
    std::error_code ignored;
    for (int round = 0; last_ > 0 && round <= last_; ++round)
      std::filesystem::remove(of(round) + "/checkpoint.bin", ignored);
  }

 private:
  std::string output_;
  int last_;
};

}  // namespace nlo::trainer
