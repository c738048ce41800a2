// SPDX-License-Identifier: MIT
// Folders of generated files. A reader sees the old folder or the new one, and nothing that a person has made or
// changed is ever overwritten: a manifest in the folder says what was generated, byte for byte.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"

namespace nlo::codegen {

/// The manifest's name in a generated folder: a line per file with the FNV-1a hash of its bytes.
inline constexpr const char* kManifest = ".nlo-export";

/// Throws Error unless `path` is a new folder, an empty one, or one as its manifest says; names what stands in the way.
void check_directory(const std::string& path);

/// Makes the folder `path`, with those above it, or replaces one that check_directory() lets pass, with `files` (paths
/// inside of it, their folders are made) and a manifest: in a folder beside it that changes names with the old one in
/// one step, where the file system can (Linux: all but some over a network; there a reader finds no folder for a
/// moment). On disk when it returns. Throws Error, and then the folder is what it was before.
void write_directory_atomically(const std::string& path, const std::vector<NamedText>& files);

}  // namespace nlo::codegen
