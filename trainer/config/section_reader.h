// SPDX-License-Identifier: MIT
// Reads the tables of a TOML file into sections by their keys, and stores the place of each key.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/config/keys.h"
#include "trainer/config/places.h"
#include "trainer/config/toml.h"

namespace nlo::trainer {

class SectionReader {
 public:
  /// Returns the title of the section that has a key, for a key in the wrong section; empty if no section has it.
  using HomeOfKey = std::function<std::string(const std::string& name)>;

  SectionReader(std::string filename, Places& places, HomeOfKey home)
      : filename_(std::move(filename)), places_(places), home_of_(std::move(home)) {}

  /// Reads one section. Throws codegen::Error `FILE:LINE: ...` for an unknown key or a value that its key refuses.
  ///   path         "observer"; empty for the keys above all sections
  ///   title        "[observer]", for messages
  ///   subsections  members that the caller reads
  template <class Section>
  void read(const Toml& table, const std::string& path, std::string_view title, const std::vector<Key<Section>>& keys,
            Section& section, const std::vector<std::string>& subsections = {}) {
    note(path, table);
    if (table.as_table().size() > kMostMembers)
      throw codegen::Error(fmt::format("{}: {} has {} keys; at most {} are allowed", places_.of(path), title,
                                       table.as_table().size(), kMostMembers));
    for (const auto& [name, value] : members_in_order(table)) {
      const std::string member = path.empty() ? name : path + "." + name;
      note(member, *value);
      if (std::find(subsections.begin(), subsections.end(), name) != subsections.end()) continue;
      const auto key = std::find_if(keys.begin(), keys.end(), [&, n = name](const auto& k) { return k.name == n; });
      if (key == keys.end()) {
        std::vector<std::string> known;
        for (const Key<Section>& k : keys) known.push_back(k.name);
        known.insert(known.end(), subsections.begin(), subsections.end());
        unknown_key(name, member, title, known);
      }
      if (value->is_string() && value->as_string().str == kChoose)
        throw codegen::Error(fmt::format("{}: {} is still {}: choose it ({}): {}", places_.of(member),
                                         path.empty() ? name : fmt::format("{} {}", title, name), kChoose, key->type,
                                         key->meaning));
      key->read(section, *value, path.empty() ? name : fmt::format("{} {}", title, name));
    }
  }

  /// Returns the table of a section; null if the file has none.
  const Toml* section(const Toml& parent, const std::string& path, const std::string& name) const {
    const auto found = parent.as_table().find(name);
    if (found == parent.as_table().end()) return nullptr;
    if (!found->second.is_table())
      throw codegen::Error(fmt::format("{}: {} is {}; it must be a section: [{}] with keys below it",
                                       place(found->second), path, type_in_words(found->second), path));
    return &found->second;
  }

  std::string place(const Toml& value) const {
    const std::string place = place_of(value);
    return place.starts_with("unknown file") ? filename_ : place;  // a section that exists only by --set
  }

 private:
  static constexpr std::size_t kMostMembers = 100;  // in a table; no section has as many keys, and few enough to search

  void note(const std::string& path, const Toml& value) { places_.note(path, place(value)); }

  [[noreturn]] void unknown_key(const std::string& name, const std::string& member, std::string_view title,
                                const std::vector<std::string>& known) const {
    const std::string nearest = nearest_name(name, known), home = home_of_(name);
    std::string advice;
    if (!home.empty()) {
      advice = fmt::format("it belongs in {}", home);
    } else if (!nearest.empty()) {
      advice = fmt::format("did you mean \"{}\"?", nearest);
    } else {
      advice = fmt::format("there are: {}", fmt::join(known, ", "));
    }
    throw codegen::Error(
        fmt::format("{}: unknown key {} in {}; {}", places_.of(member), toml_text(name), title, advice));
  }

  std::string filename_;
  Places& places_;
  HomeOfKey home_of_;
};

}  // namespace nlo::trainer
