// SPDX-License-Identifier: MIT
// Decides which names of users may become code: namespaces, enumerators, file names.
#pragma once

#include <string_view>

namespace nlo::codegen {

/// Returns true if the text is safe as a namespace, an enumerator and a file name: `[A-Za-z][A-Za-z0-9_]{0,62}`,
/// without a double underscore, and no word that C++, its standard macros or a generated header use.
bool is_identifier(std::string_view text);

}  // namespace nlo::codegen
