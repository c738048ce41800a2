// SPDX-License-Identifier: MIT
// Names of enumerations: one table for each enumeration, which keys, messages and help use.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace nlo::trainer {

template <class E, std::size_t kCount>
using NameTable = std::array<std::pair<E, std::string_view>, kCount>;

/// The table of an enumeration, in the order of the help. Specialise it beside the enumeration.
template <class E>
inline constexpr NameTable<E, 0> kNames{};

/// An enumeration with a table.
template <class E>
concept Named = std::is_enum_v<E> && !kNames<E>.empty();

template <Named E>
constexpr std::string_view to_name(E value) {
  for (const auto& [known, name] : kNames<E>)
    if (known == value) return name;
  return "";  // not an enumerator; a new enumerator needs a line in the table
}

/// Returns nothing if the text is not a name of the enumeration.
template <Named E>
constexpr std::optional<E> from_name(std::string_view text) {
  for (const auto& [value, name] : kNames<E>)
    if (name == text) return value;
  return std::nullopt;
}

template <Named E>
std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const auto& entry : kNames<E>) names.emplace_back(entry.second);
  return names;
}

}  // namespace nlo::trainer
