// SPDX-License-Identifier: MIT
#include "trainer/dossier/dossier_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/config/section_reader.h"

namespace nlo::trainer {
namespace {

const std::vector<Key<DossierItem>>& item_keys() {
  static const std::vector<Key<DossierItem>> kKeys = {
      key("file", &DossierItem::file, any(), "in the folder"),
      key("what", &DossierItem::what, any(), "for the reader"),
      key("command", &DossierItem::command, any(), "of nlo, run in the folder"),
      key("script", &DossierItem::script, any(), "of the source tree"),
      key("needs", &DossierItem::needs, one_of({"plant", "training", "logs", "tree", "judgement"}),
          "else it is not made"),
      key("again", &DossierItem::again, any(), "how to make it where no command does"),
      key("refusable", &DossierItem::refusable, any(), "its command may refuse a model"),
  };
  return kKeys;
}

const std::vector<Key<EvidenceRow>>& row_keys() {
  static const std::vector<Key<EvidenceRow>> kKeys = {
      key("asks", &EvidenceRow::asks, any(), "what is asked"),
      key("files", &EvidenceRow::files, any(), "of the folder"),
      key("tests", &EvidenceRow::tests, any(), "of the source tree"),
      key("integrator", &EvidenceRow::integrator, any(), "what is left to the integrator"),
  };
  return kKeys;
}

const std::vector<Key<Standard>>& standard_keys() {
  static const std::vector<Key<Standard>> kKeys = {key("name", &Standard::name, any(), "with its edition")};
  return kKeys;
}

std::string no_other_home(const std::string&) {
  return "";
}

/// Calls `take` with each table of the array `name` of `parent`, and its path.
template <class Take>
void each_table(const Toml& parent, const std::string& path, const std::string& name, const Take& take) {
  const auto found = parent.as_table().find(name);
  if (found == parent.as_table().end()) return;
  std::size_t count = 0;
  for (const Toml& table : list_of(found->second, "[[" + name + "]]", {})) {
    if (!table.is_table()) throw codegen::Error(fmt::format("{}: {} is not a table", place_of(table), name));
    take(table, fmt::format("{}{}[{}]", path, name, count++));
  }
}

void check_files(const DossierTable& table, const EvidenceRow& row, const std::string& place) {
  for (const std::string& file : row.files)
    if (std::ranges::find(table.items, file, &DossierItem::file) == table.items.end())
      throw codegen::Error(fmt::format("{}: \"{}\" names {}, which no [[item]] makes", place, row.asks, file));
}

}  // namespace

DossierTable parse_dossier_table(std::string_view text, const std::string& filename) {
  const Toml root = parse_toml(text, filename);
  Places places(filename);
  SectionReader reader(filename, places, no_other_home);
  DossierTable result;
  each_table(root, "", "item", [&](const Toml& table, const std::string& path) {
    reader.read(table, path, "[[item]]", item_keys(), result.items.emplace_back());
  });
  const auto read_row = [&](const Toml& table, const std::string& path, std::vector<EvidenceRow>& rows) {
    reader.read(table, path, "a row of evidence", row_keys(), rows.emplace_back());
    check_files(result, rows.back(), reader.place(table));
  };
  each_table(root, "", "requirement",
             [&](const Toml& table, const std::string& path) { read_row(table, path, result.requirements); });
  each_table(root, "", "standard", [&](const Toml& table, const std::string& path) {
    Standard& standard = result.standards.emplace_back();
    reader.read(table, path, "[[standard]]", standard_keys(), standard, {"row"});
    each_table(table, path + ".", "row",
               [&](const Toml& row, const std::string& where) { read_row(row, where, standard.rows); });
  });
  return result;
}

const DossierTable& dossier_table() {
  static const DossierTable kTable = parse_dossier_table(kDossierTable, "dossier.toml");
  return kTable;
}

}  // namespace nlo::trainer
