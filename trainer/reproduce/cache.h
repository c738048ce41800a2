// SPDX-License-Identifier: MIT
// Trained models by what they were trained from: DIR/cache/<hash>/model.json. An unfinished training leaves its
// checkpoint there, and goes on from it.
#pragma once

#include <optional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer::reproduction {

class ModelCache {
 public:
  explicit ModelCache(std::string directory) : directory_(std::move(directory)) {}

  /// 16 hex digits of the experiment (every key, the seed among them) and the program's version.
  static std::string hash(const Experiment& experiment);

  /// Where an experiment's files lie.
  std::string path(const Experiment& experiment) const;

  /// The finished model, or nothing: not there, damaged or altered since it was stored (a hash of its bytes lies beside
  /// it), or (should two hashes meet) another experiment's.
  std::optional<codegen::Model> find(const Experiment& experiment) const;

  /// Keeps a finished model and drops its checkpoint.
  void store(const Experiment& experiment, const codegen::Model& model) const;

 private:
  std::string directory_;
};

}  // namespace nlo::trainer::reproduction
