// SPDX-License-Identifier: MIT
// Converts model files of older versions to the current version before they are read, with one function for each step.
// docs/model_files.md says which changes need a new version.
#pragma once

#include <nlohmann/json.hpp>

namespace nlo::codegen {

/// The version that this program writes. It reads this version and all earlier ones.
inline constexpr int kModelVersion = 2;

/// Converts `file` from `version`, which is 1 to kModelVersion, to kModelVersion. Throws Error if it has a field that
/// its version does not have. The reader checks that no field is missing.
void upgrade(nlohmann::ordered_json& file, int version);

}  // namespace nlo::codegen
