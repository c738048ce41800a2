// SPDX-License-Identifier: MIT
// The observer in C99, for compilers that have no C++20: NAME.h and NAME.c, which need no library at all and give the
// bits of the C++ runtime's deterministic policy, of the monitor too.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Throws Error, naming the fix, unless the model is of a structure that C99 has; `target` is whose message it is.
void check_c99(const Model& model, const std::string& target = "c99");

/// NAME.h and NAME.c: the same bytes for the same model. Throws Error when check_c99() does, or when a
/// number does not fit the scalar.
std::vector<NamedText> c99(const PreparedExport& prepared);

/// For targets that fill the same templates into other files (single_header.cpp): the export with the most accurate
/// tanh, after the checks of c99(); the values of the templates' keys, with functions called NAME_step and so on; and
/// the comment at the top of a file.
PreparedExport for_c99(const PreparedExport& prepared, const std::string& target);
std::map<std::string, std::string> c99_values(const PreparedExport& prepared, const std::string& name);
std::string c99_top(const PreparedExport& prepared, const char* language, const char* target,
                    const std::string& example);

}  // namespace nlo::codegen
