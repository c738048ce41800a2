// SPDX-License-Identifier: MIT
// The result of an identification as tables for readers and as JSON for programs.
#pragma once

#include <string>

#include "trainer/identify/filter_study.h"
#include "trainer/identify/identify.h"

namespace nlo::trainer {

/// Returns the parameters with their standard errors, the errors over segments, and notes on parameters that the data
/// do not determine.
std::string to_text(const IdentificationResult& result);

/// Returns a table for each logged state: estimators and windows.
std::string to_text(const FilterStudy& study);

/// Returns both as JSON; `study` may be null. NaN is written as null.
std::string identification_json(const std::string& name, const IdentificationResult& result, const FilterStudy* study);

}  // namespace nlo::trainer
