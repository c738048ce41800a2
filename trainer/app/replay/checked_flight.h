// SPDX-License-Identifier: MIT
// An export is compiled and flown before it is written.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::trainer {

/// Compiles each observer among `files`, an export of `prepared`, and steps it with the model's replay inputs. Statuses
/// must equal the model's, and estimates must stay within the error of the arithmetic, as golden_replay.h states it.
/// C99 and the header with the deterministic policy are written by different code and must agree to the bit. Returns a
/// line for each observer. Throws codegen::Error with the first sample that differs and both values, or without a
/// compiler.
std::string check_flight(const codegen::PreparedExport& prepared, const std::vector<codegen::NamedText>& files);

}  // namespace nlo::trainer
