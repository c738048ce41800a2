// SPDX-License-Identifier: MIT
// Writes folders of generated files. A reader sees the old folder or the new one. Files that a person has made or
// changed are never overwritten: a manifest in the folder lists the generated files, byte for byte.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"

namespace nlo::codegen {

/// File name of the manifest in a generated folder. It has a line per file with the FNV-1a hash of its bytes.
inline constexpr const char* kManifest = ".nlo-export";

/// Throws Error unless `path` does not exist, is empty, or agrees with its manifest. The error names the first file
/// that does not agree.
void check_directory(const std::string& path);

/// Writes `files` (paths inside of the folder) and a manifest into the folder `path`, which is made with its parents or
/// replaced if check_directory() accepts it. The files are written to a folder beside it, and the two are exchanged in
/// one step. (On some network file systems there is no folder for a moment.) All files are on disk at the end. On an
/// Error the folder is unchanged.
void write_directory_atomically(const std::string& path, const std::vector<NamedText>& files);

}  // namespace nlo::codegen
