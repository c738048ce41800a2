// SPDX-License-Identifier: MIT
// The keys of an experiment file: reading, writing, suggestions and help come from one table for each section
// (experiments/section_keys.cpp), one line for each key.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "trainer/config/toml.h"
#include "trainer/config/value.h"

namespace nlo::trainer {

template <class Section>
struct Key {
  std::string name;
  std::string type;     ///< in words, with the range
  std::string meaning;  ///< for the help, with the unit
  std::function<void(Section&, const Toml&, const std::string& where)> read;
  std::function<std::string(const Section&)> show;  ///< returns the value as TOML
  bool only_when_given = false;                     ///< not written to an experiment's text if it has its default
};

/// Makes a key that is a member of its section.
template <class Section, class Field>
Key<Section> key(std::string name, Field Section::*field, const Rule& rule, std::string meaning) {
  std::string type = type_of(Field{});
  if (const std::string words = rule.in_words(); !words.empty()) type += " " + words;
  return {std::move(name),
          std::move(type),
          std::move(meaning),
          [=](Section& section, const Toml& value, const std::string& where) {
            read_value(value, where, rule, section.*field);
          },
          [=](const Section& section) { return show_value(section.*field); },
          false};
}

/// Makes a key that is a member of a module's struct in the section, section.own.get<Own>().
template <class Section, class Own>
Key<Section> own_key(Key<Own> key) {
  return {std::move(key.name),
          std::move(key.type),
          std::move(key.meaning),
          [read = std::move(key.read)](Section& section, const Toml& value, const std::string& where) {
            read(section.own.template set<Own>(), value, where);
          },
          [show = std::move(key.show)](const Section& section) { return show(section.own.template get<Own>()); },
          true};
}

/// Returns true if one of `keys` has this name.
template <class Section>
bool has_key(const std::vector<Key<Section>>& keys, std::string_view name) {
  return std::any_of(keys.begin(), keys.end(), [&](const Key<Section>& key) { return key.name == name; });
}

/// Returns true if a value is empty in its TOML form: "", [], {}.
inline bool is_empty_value(std::string_view shown) {
  return shown == "\"\"" || shown == "[]" || shown == "{}";
}

}  // namespace nlo::trainer
