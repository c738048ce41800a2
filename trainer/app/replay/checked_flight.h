// SPDX-License-Identifier: MIT
// An export is compiled and flown before it is written.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"

namespace nlo::trainer {

/// Compiles each observer among `files`, an export of `prepared`, and gives it the model's replay inputs: statuses must
/// be the model's, estimates within what the arithmetic explains (codegen/targets/replay.h). C99, and the header with
/// the deterministic policy, which are written by different code, must then agree to the bit. Returns a line for each,
/// what was seen. Throws codegen::Error: the first sample that differs, both values; or that nothing here compiles it.
std::string check_flight(const codegen::PreparedExport& prepared, const std::vector<codegen::NamedText>& files);

}  // namespace nlo::trainer
