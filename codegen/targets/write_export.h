// SPDX-License-Identifier: MIT
// Writes an export: one file under the name that the user gives, several beside each other, or a folder.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/target_registry.h"

namespace nlo::codegen {

/// Throws Error if `output` is no place for the files of `target`:
///   kFile       `output` is the file
///   kFiles      `output` is the first of the files and must have its name, for the others include it by that
///   kDirectory  `output` is the folder: new, empty, or as an export has left it
void check_export(const ExportTarget& target, const std::vector<NamedText>& files, const std::string& output);

/// Writes them there, all or none. Returns where each went. Throws Error when the file system refuses.
std::vector<std::string> write_export(const ExportTarget& target, const std::vector<NamedText>& files,
                                      const std::string& output);

}  // namespace nlo::codegen
