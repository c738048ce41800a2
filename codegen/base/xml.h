// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace nlo::codegen {

/// `text` as it stands between tags and in attributes of XML and HTML; control characters, which XML has no way to
/// write, become _.
std::string xml_escaped(std::string_view text);

}  // namespace nlo::codegen
