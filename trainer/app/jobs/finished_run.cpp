// SPDX-License-Identifier: MIT
#include "trainer/app/jobs/finished_run.h"

#include <nlohmann/json.hpp>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {
namespace {

std::string file_in(const std::string& directory) {
  return directory + "/finished.json";
}

std::uint64_t hash_of(const std::string& text) {
  return fingerprint(text.data(), text.size());
}

std::uint64_t hash_of_model(const std::string& directory) {
  return hash_of(codegen::read_file(directory + "/model.json"));
}

}  // namespace

std::uint64_t run_identity(const Experiment& experiment) {
  return hash_of(experiment.source_text + "\n" + std::to_string(experiment.seed));
}

void write_finished_run(const std::string& directory, const FinishedRun& run) {
  const nlohmann::ordered_json json = {{"experiment", run.experiment},
                                       {"data", run.data},
                                       {"model", hash_of_model(directory)},
                                       {"failure", run.failure}};
  codegen::write_file_atomically(file_in(directory),
                                 json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<FinishedRun> read_finished_run(const std::string& directory) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  try {
    const auto json = nlohmann::json::parse(codegen::read_file(file_in(directory), kMostBytes));
    if (json.at("model").get<std::uint64_t>() != hash_of_model(directory)) return std::nullopt;
    return FinishedRun{json.at("experiment").get<std::uint64_t>(), json.at("data").get<std::uint64_t>(),
                       json.at("failure").get<std::string>()};
  } catch (const codegen::Error&) {  // no such file
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {  // not written by this program
    return std::nullopt;
  }
}

}  // namespace nlo::trainer
