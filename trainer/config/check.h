// SPDX-License-Identifier: MIT
// What the keys of an experiment must satisfy together: sizes that agree, sections that exclude each other, a latent
// system that is stable at the sample period, angles that the observer can turn with.
#pragma once

#include <map>
#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Where a key ("observer.hold"), a section ("log", "log.columns[2]") was written: "FILE:LINE" or "--set KEY=VALUE".
class Places {
 public:
  explicit Places(std::string filename) : filename_(std::move(filename)) {}

  void note(const std::string& path, std::string place) { places_[path] = std::move(place); }
  bool has(const std::string& path) const { return places_.contains(path); }

  /// Of the path, else of the section it belongs to, else the file.
  std::string of(const std::string& path) const;

 private:
  std::string filename_;
  std::map<std::string, std::string> places_;
};

/// Throws codegen::Error `FILE:LINE: what is wrong; what to do`.
void check_experiment(const Experiment& experiment, const Places& places);

}  // namespace nlo::trainer
