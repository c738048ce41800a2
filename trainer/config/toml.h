// SPDX-License-Identifier: MIT
// TOML text to values with their places, safe for text from anywhere: toml11 3.7 recurses per bracket and per dot and
// would overflow the stack, so size, encoding and nesting are checked first.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <toml.hpp>
#include <vector>

namespace nlo::trainer {

using Toml = toml::basic_value<toml::discard_comments, std::map, std::vector>;

constexpr std::size_t kMaxConfigBytes = std::size_t{1} << 20;

/// Throws codegen::Error `FILE:LINE: ...` for text that is too big, not UTF-8, too deep or not TOML.
Toml parse_toml(std::string_view text, const std::string& filename);

/// Sets `section.key` in `root` from "section.key=value", a TOML value; a bare word (letters, digits, _ : . -) is taken
/// as a string, so that shells need no second pair of quotes. Errors name the override.
void apply_override(Toml& root, const std::string& assignment);

/// "FILE:LINE" of a value, or "--set KEY=VALUE" when it came from there.
std::string place_of(const Toml& value);

/// The members of a table in the order they are written.
std::vector<std::pair<std::string, const Toml*>> members_in_order(const Toml& table);

/// "an integer", "a string"... as people say it.
std::string_view type_in_words(const Toml& value);

/// A string as a TOML literal.
std::string toml_text(std::string_view text);

}  // namespace nlo::trainer
