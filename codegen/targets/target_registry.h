// SPDX-License-Identifier: MIT
// The targets of an export. A new target is one file beside this one and one line in target_registry.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// The files of an export.
enum class ExportForm : std::uint8_t {
  kFile,       ///< one file, under any name
  kFiles,      ///< several files in one folder that include each other by name; a user includes the first
  kDirectory,  ///< a folder of its own
};

struct ExportTarget {
  std::string name;         ///< on the command line
  std::string description;  ///< one line of help
  ExportForm form;
  /// Generates the files, with their paths relative to `output` of write_export(). Throws Error.
  std::function<std::vector<NamedText>(const PreparedExport&)> generate;
  bool of_c99 = false;       ///< has only what the c99 pair has: no standard deviations, one tanh
  bool roles = false;        ///< needs the roles of channels (ExportOptions::roles)
  bool no_observer = false;  ///< its files are used with the observer of another target
};

const std::vector<ExportTarget>& export_targets();

/// Returns the target with this name. Throws Error, which lists all names.
const ExportTarget& export_target(const std::string& name);

}  // namespace nlo::codegen
