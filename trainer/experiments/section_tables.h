// SPDX-License-Identifier: MIT
// Reads sections of a TOML file with the tables of keys.h, for experiments and identifications.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/section_reader.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

/// Returns the title of the section that has a key with this name, or an empty text.
std::string home_of_key(const std::string& name);

class SectionTables : public SectionReader {
 public:
  SectionTables(const std::string& filename, Places& places) : SectionReader(filename, places, home_of_key) {}

  template <class Section>
  void read(const Toml& table, const std::string& path, Section& section,
            const std::vector<std::string>& subsections = {}) {
    SectionReader::read(table, path, section_title<Section>(), keys<Section>(), section, subsections);
  }

  /// Reads the tables of a list, which is `name` of `parent` and [[path]] in the file.
  template <class Section>
  std::vector<Section> read_list(const Toml& parent, const std::string& path, const std::string& name) {
    std::vector<Section> list;
    const auto found = parent.as_table().find(name);
    if (found == parent.as_table().end()) return list;
    const std::string title(section_title<Section>());
    for (const Toml& table : list_of(found->second, title, any())) {
      if (!table.is_table())
        throw codegen::Error(fmt::format("{}: {} is {}; each is a table: {} with keys below it", place(table), title,
                                         type_in_words(table), title));
      Section& section = list.emplace_back();
      read(table, fmt::format("{}[{}]", path, list.size() - 1), section);
    }
    return list;
  }

  /// Reads a section at the top of the file. Missing keys stay unchanged.
  template <class Section>
  void read_if_there(const Toml& root, const std::string& name, Section& section) {
    if (const Toml* table = this->section(root, name, name)) read(*table, name, section);
  }
};

/// Reads [log] with its filter and its columns.
LogConfig read_log_section(SectionTables& reader, const Toml& table);

}  // namespace nlo::trainer
