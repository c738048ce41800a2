// SPDX-License-Identifier: MIT
// Parses TOML text to values with their places, safely for any text. toml11 3.7 recurses per bracket and per dot and
// could overflow the stack, so size, encoding and nesting are checked first.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <toml.hpp>
#include <vector>

namespace nlo::trainer {

using Toml = toml::basic_value<toml::discard_comments, std::map, std::vector>;

constexpr std::size_t kMaxConfigBytes = std::size_t{1} << 20;

/// Parses a text. Throws codegen::Error `FILE:LINE: ...` for text that is too long, not UTF-8, nested too deeply or not
/// TOML.
Toml parse_toml(std::string_view text, const std::string& filename);

/// Sets `section.key` in `root` from "section.key=value" with a TOML value. A bare word (letters, digits, _ : . -) is
/// read as a string, so that a shell needs no second pair of quotes. Errors name the override.
void apply_override(Toml& root, const std::string& assignment);

/// Returns "FILE:LINE" of a value, or "--set KEY=VALUE" if it came from --set.
std::string place_of(const Toml& value);

/// Returns the members of a table in the order of the file.
std::vector<std::pair<std::string, const Toml*>> members_in_order(const Toml& table);

/// Returns "an integer", "a string", ... for messages.
std::string_view type_in_words(const Toml& value);

/// Returns a string as a TOML literal.
std::string toml_text(std::string_view text);

}  // namespace nlo::trainer
