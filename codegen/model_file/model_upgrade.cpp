// SPDX-License-Identifier: MIT
#include "codegen/model_file/model_upgrade.h"

#include <string>
#include <utility>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

using Json = nlohmann::ordered_json;

/// Version 1 had only the structure KKL, and its inverse map was among the fields of the model.
void from_1(Json& file) {
  constexpr std::pair<const char*, const char*> kMoved[] = {{"features", "features"},
                                                            {"feature_mean", "feature_mean"},
                                                            {"feature_scale", "feature_scale"},
                                                            {"activation", "activation"},
                                                            {"layers", "layers"},
                                                            {"skip", "skip"},
                                                            {"state_mean", "output_mean"},
                                                            {"state_scale", "output_scale"}};
  for (const char* later : {"structure", "inverse_map"})
    if (file.contains(later))
      throw Error(std::string(later) + ": is not a field of version 1; give the file as nlo wrote it");
  Json map = Json::object();
  for (const auto& [before, after] : kMoved) {
    if (!file.contains(before)) continue;
    map[after] = std::move(file[before]);
    file.erase(before);
  }
  file["structure"] = "kkl";
  file["inverse_map"] = std::move(map);
}

}  // namespace

void upgrade(nlohmann::ordered_json& file, int version) {
  if (version < 2) from_1(file);
  // reference_sensor was called witness up to version 0.3.
  if (file.contains("monitor") && file["monitor"].is_object() && file["monitor"].contains("witness")) {
    Json& monitor = file["monitor"];
    monitor["reference_sensor"] = std::move(monitor["witness"]);
    monitor.erase("witness");
  }
  file["version"] = kModelVersion;
}

}  // namespace nlo::codegen
