// SPDX-License-Identifier: MIT
// What goes into the world: an export that has been read back.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"
#include "codegen/readback/common_quantities.h"
#include "codegen/targets/registry.h"

namespace nlo::codegen {

/// An observer in one language among the files of an export: a C99 pair, a C++ header.
struct GeneratedObserver {
  TextForm form;
  std::string name;
  std::vector<NamedText> files;  ///< the header first
};

/// Those among `files`, or in the archive that these are.
std::vector<GeneratedObserver> observers_in(const std::vector<NamedText>& files);

/// `prepared` under the name that this one of its observers has.
PreparedExport named(const PreparedExport& prepared, const std::string& name);

/// The files of `target`, once each observer among them says what the model says (codegen/readback). Throws Error where
/// one does not, and where the model cannot be exported so.
std::vector<NamedText> generated(const ExportTarget& target, const PreparedExport& prepared);

}  // namespace nlo::codegen
