// SPDX-License-Identifier: MIT
// Writes the observer in C99, for compilers without C++20: NAME.h and NAME.c. They need no library and compute the same
// bits as the deterministic policy of the C++ runtime, also for the monitor.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Throws Error with the remedy if C99 does not support the structure of the model. `target` is the target in the
/// message.
void check_c99(const Model& model, const std::string& target = "c99");

/// Returns NAME.h and NAME.c, with the same bytes for the same model. Throws Error if check_c99() does, or if the
/// scalar cannot represent a number.
std::vector<NamedText> c99(const PreparedExport& prepared);

/// The next functions are for targets that put the same templates into other files (single_header.cpp). They return the
/// export with the most accurate tanh, after the checks of c99(); the values for the keys of the templates, with
/// functions called NAME_step and so on; and the comment at the top of a file.
PreparedExport for_c99(const PreparedExport& prepared, const std::string& target);
std::map<std::string, std::string> c99_values(const PreparedExport& prepared, const std::string& name);
std::string c99_top(const PreparedExport& prepared, const char* language, const char* target,
                    const std::string& example);

}  // namespace nlo::codegen
