// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace nlo::codegen {

/// Escapes `text` for use between tags and in attributes of XML and HTML. Control characters, which XML cannot express,
/// become _.
std::string xml_escaped(std::string_view text);

}  // namespace nlo::codegen
