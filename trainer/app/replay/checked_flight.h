// SPDX-License-Identifier: MIT
// Compiles and runs an export before it is written.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::trainer {

/// Compiles each observer among `files`, an export of `prepared`, and steps it with the model's replay inputs. Statuses
/// must equal those of the model, and estimates must stay within the error of the arithmetic (golden_replay.h). C99 and
/// the header with the deterministic policy are different code and must agree bit for bit. Returns a line for each
/// observer. Throws codegen::Error with the first sample that differs and both values, or if there is no compiler.
std::string check_flight(const codegen::PreparedExport& prepared, const std::vector<codegen::NamedText>& files);

}  // namespace nlo::trainer
