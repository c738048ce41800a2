// SPDX-License-Identifier: MIT
// In a file of its own, so that a new version compiles one source again and not all of them.
#pragma once

namespace nlo::trainer {

/// Version of the project: "0.2.0".
extern const char* const kVersion;

}  // namespace nlo::trainer
