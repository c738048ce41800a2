// SPDX-License-Identifier: MIT
// The result of an identification as tables for people and as JSON for programs.
#pragma once

#include <string>

#include "trainer/identify/filter_study.h"
#include "trainer/identify/identify.h"

namespace nlo::trainer {

/// Parameters with their standard errors, the errors over segments, and notes on parameters that the data do not
/// determine.
std::string to_text(const IdentificationResult& result);

/// A table for each logged state: estimators and windows.
std::string to_text(const FilterStudy& study);

/// Both; `study` may be null. NaN is null.
std::string identification_json(const std::string& name, const IdentificationResult& result, const FilterStudy* study);

}  // namespace nlo::trainer
