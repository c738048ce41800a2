// SPDX-License-Identifier: MIT
// The version has its own file, so that a new version recompiles one source instead of all.
#pragma once

namespace nlo::trainer {

/// Version of the project: "0.2.0".
extern const char* const kVersion;

}  // namespace nlo::trainer
