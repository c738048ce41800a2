// SPDX-License-Identifier: MIT
// Writes folders with the C99 pair and the files of a framework around it. Each file comes from a template
// (templates/simulink, templates/px4, templates/simplefoc).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns a level-2 S-function for Simulink. Throws Error if c99() does.
std::vector<NamedText> simulink(const PreparedExport& prepared);

/// Returns a module for PX4. Throws Error if c99() does.
std::vector<NamedText> px4_module(const PreparedExport& prepared);

/// Returns a library for Arduino with a `Sensor` of SimpleFOC, whose velocity is an estimate (simplefoc.cpp decides
/// which). Throws Error if c99() does, or if options().roles and the model do not determine an angle and a velocity.
std::vector<NamedText> simplefoc(const PreparedExport& prepared);

/// Returns the files of a wrapper: the C99 pair in the folder `sources` ("src/"), and templates/TARGET filled with the
/// values that all wrappers share and with `more`.
std::vector<NamedText> around_c99(const PreparedExport& prepared, const std::string& target,
                                  std::map<std::string, std::string> more = {}, const std::string& sources = "");

}  // namespace nlo::codegen
