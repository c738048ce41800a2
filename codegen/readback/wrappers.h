// SPDX-License-Identifier: MIT
// What stands around an observer, blocks, modules, packages, names its sample period and its sizes too.
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

/// Throws Error, naming file, line and both values, where one of `files` has another period, size or initial state than
/// `model`, or has lost the place where it stood.
void check_wrappers(const Model& model, const std::vector<NamedText>& files);

}  // namespace nlo::codegen
