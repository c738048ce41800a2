// SPDX-License-Identifier: MIT
// Which names from users may become code: namespaces, enumerators, file names.
#pragma once

#include <string_view>

namespace nlo::codegen {

/// `[A-Za-z][A-Za-z0-9_]{0,62}`, no doubled underscore, no word that C++, its standard macros or a generated header
/// have taken: safe as a namespace, an enumerator and a file name.
bool is_identifier(std::string_view text);

}  // namespace nlo::codegen
