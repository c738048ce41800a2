// SPDX-License-Identifier: MIT
// Model files of older versions, brought up to that of today before they are read: one function for each step.
// docs/model_files.md says which changes make a new version.
#pragma once

#include <nlohmann/json.hpp>

namespace nlo::codegen {

/// The version that this program writes. It reads this version and all earlier ones.
inline constexpr int kModelVersion = 2;

/// Changes `file`, of `version` from 1 to kModelVersion, to kModelVersion. Throws Error when it holds a field that its
/// version does not have; whether it is complete is for the reader to say.
void upgrade(nlohmann::ordered_json& file, int version);

}  // namespace nlo::codegen
