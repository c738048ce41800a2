// SPDX-License-Identifier: MIT
// Linked into the program alone, so that a changed source links it again and not every test.
#pragma once

namespace nlo::trainer {

/// SHA-256 over the sums of all files of runtime, codegen and trainer that the program was built from
/// (source_hash.cmake).
extern const char* const kSourceHash;

}  // namespace nlo::trainer
