// SPDX-License-Identifier: MIT
// Files of the source tree that are compiled into the program: the templates of exports and the headers of the runtime.
// cmake/embed_texts.cmake generates their source.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

namespace nlo::codegen {

struct EmbeddedText {
  std::string_view name, text;
};

/// Returns all files. A template has its path below codegen/targets/templates ("c99/observer.c.in"), a header of the
/// runtime its name in an #include ("nlo/vector.h").
std::span<const EmbeddedText> embedded_texts();

/// Returns the text of that name. Throws std::logic_error if there is none.
std::string_view embedded_text(std::string_view name);

/// Fills a template. Each @KEY@ (capitals, digits, underscores) is replaced by its value. `@if KEY@`, `@else@` and
/// `@end@`, each on a line of its own, select lines: those behind @if@ if the value is not empty, otherwise those
/// behind @else@. Throws std::logic_error for a key without a value, and for sections that do not nest.
std::string filled(std::string_view text, const std::map<std::string, std::string>& values);

}  // namespace nlo::codegen
