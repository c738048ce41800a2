// SPDX-License-Identifier: MIT
// Finds the observers among the files of an export.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

enum class TextForm : std::uint8_t {
  kCpp,     ///< the C++ header over the runtime
  kC99,     ///< the C99 pair
  kSingle,  ///< the C99 pair joined in one C++ header
};

/// An observer in one language among the files of an export: a C99 pair or a C++ header.
struct GeneratedObserver {
  TextForm form;
  std::string name;
  std::vector<NamedText> files;  ///< the header is the first
};

/// Returns the observers in `files`, or in an archive among them.
std::vector<GeneratedObserver> observers_in(const std::vector<NamedText>& files);

/// Returns `prepared` under the name that it has in one of its observers.
PreparedExport named(const PreparedExport& prepared, const std::string& name);

}  // namespace nlo::codegen
