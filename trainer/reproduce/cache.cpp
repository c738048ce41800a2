// SPDX-License-Identifier: MIT
#include "trainer/reproduce/cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/version.h"
#include "trainer/training/checkpoint.h"

namespace nlo::trainer::reproduction {
namespace {

namespace fs = std::filesystem;

std::string recorded(const codegen::Model& model, const char* fact) {
  const auto found = std::find_if(model.provenance.begin(), model.provenance.end(),
                                  [fact](const auto& entry) { return entry.first == fact; });
  return found == model.provenance.end() ? "" : found->second;
}

/// Of the model's bytes: a changed digit would be a valid model too.
std::string seal_of(const std::string& model_file) {
  const std::string bytes = codegen::read_file(model_file);
  return fmt::format("{:016x}\n", fingerprint(bytes.data(), bytes.size()));
}

}  // namespace

std::string ModelCache::hash(const Experiment& experiment) {
  const std::string identity = std::string(kVersion) + '\n' + experiment.source_text;
  return fmt::format("{:016x}", fingerprint(identity.data(), identity.size()));
}

std::string ModelCache::path(const Experiment& experiment) const {
  return directory_ + "/" + hash(experiment);
}

std::optional<codegen::Model> ModelCache::find(const Experiment& experiment) const {
  const std::string file = path(experiment) + "/model.json";
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  try {
    if (codegen::read_file(path(experiment) + "/model.hash") != seal_of(file)) return std::nullopt;
    codegen::Model model = codegen::read_model(file);
    if (recorded(model, "config") == experiment.source_text) return model;
  } catch (const codegen::Error&) {  // damaged: train it again, and replace it
  }
  return std::nullopt;
}

void ModelCache::store(const Experiment& experiment, const codegen::Model& model) const {
  fs::create_directories(path(experiment));
  const std::string file = path(experiment) + "/model.json";
  codegen::write_model(model, file);
  codegen::write_file_atomically(path(experiment) + "/model.hash", seal_of(file));
  std::error_code ignored;
  fs::remove(path(experiment) + "/checkpoint.bin", ignored);
}

}  // namespace nlo::trainer::reproduction
