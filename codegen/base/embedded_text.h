// SPDX-License-Identifier: MIT
// Files of the source tree that the program carries within it: the templates of exports, and the runtime's headers for
// those that pack them. CMake makes their source (cmake/embed_texts.cmake).
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

namespace nlo::codegen {

struct EmbeddedText {
  std::string_view name, text;
};

/// All of them. A template is named as below codegen/targets/templates ("c99/observer.c.in"), a header of the runtime
/// as it is included ("nlo/vector.h").
std::span<const EmbeddedText> embedded_texts();

/// The text of that name. Throws std::logic_error when there is none.
std::string_view embedded_text(std::string_view name);

/// A template filled: each @KEY@ (capitals, digits, underscores) becomes its value, and of lines between `@if KEY@`,
/// `@else@` and `@end@`, each alone on its line, those stay that the value, empty or not, asks for. Throws
/// std::logic_error for a key without a value, and for sections that do not nest.
std::string filled(std::string_view text, const std::map<std::string, std::string>& values);

}  // namespace nlo::codegen
