// SPDX-License-Identifier: MIT
// The observers among the files of an export.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

enum class TextForm : std::uint8_t {
  kCpp,     ///< the C++ header over the runtime
  kC99,     ///< the pair
  kSingle,  ///< the same in one C++ header
};

/// An observer in one language among the files of an export: a C99 pair, a C++ header.
struct GeneratedObserver {
  TextForm form;
  std::string name;
  std::vector<NamedText> files;  ///< the header first
};

/// Finds the observers in `files`, or in an archive among them.
std::vector<GeneratedObserver> observers_in(const std::vector<NamedText>& files);

/// `prepared` under the name that this one of its observers has.
PreparedExport named(const PreparedExport& prepared, const std::string& name);

}  // namespace nlo::codegen
