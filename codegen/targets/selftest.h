// SPDX-License-Identifier: MIT
// Writes a program that tests an observer on its target: golden replay, and cycles of a step and an estimate.
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns the C99 pair, its replay, the test, a header of cycle counters and a main.c. Throws Error if c99() does.
std::vector<NamedText> selftest(const PreparedExport& prepared);

}  // namespace nlo::codegen
