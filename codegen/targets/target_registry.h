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
  kFiles,      ///< several that include each other by name, in one folder; the first is the one to include
  kDirectory,  ///< a folder of its own
};

struct ExportTarget {
  std::string name;         ///< on the command line
  std::string description;  ///< one line of help
  ExportForm form;
  /// The files, their paths relative to where the export goes. Throws Error.
  std::function<std::vector<NamedText>(const PreparedExport&)> generate;
  bool of_c99 = false;       ///< has the parts of the c99 pair only: no standard deviations, one tanh
  bool roles = false;        ///< needs roles of channels (ExportOptions::roles)
  bool no_observer = false;  ///< its files belong to an observer of another target
};

const std::vector<ExportTarget>& export_targets();

/// The target of that name. Throws Error that lists the names there are.
const ExportTarget& export_target(const std::string& name);

}  // namespace nlo::codegen
