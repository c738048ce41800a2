// SPDX-License-Identifier: MIT
// dossier.toml as values: which files a dossier has, and which of them answer what.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

struct DossierItem {
  std::string file, what, command, script, needs, again;
  bool refusable = false;
};

/// What is asked, and where its answer stands.
struct EvidenceRow {
  std::string asks;
  std::vector<std::string> files;  ///< of the folder, by their items
  std::vector<std::string> tests;  ///< "path" or "path Suite.Test", of the source tree
  std::string integrator;          ///< what is left to the one who builds the observer in
};

struct Standard {
  std::string name;
  std::vector<EvidenceRow> rows;
};

struct DossierTable {
  std::vector<DossierItem> items;
  std::vector<EvidenceRow> requirements;
  std::vector<Standard> standards;
};

/// The text of dossier.toml.
extern const std::string_view kDossierTable;

/// Throws codegen::Error `FILE:LINE: ...`, also where evidence names a file that no item makes.
DossierTable parse_dossier_table(std::string_view text, const std::string& filename);

const DossierTable& dossier_table();

}  // namespace nlo::trainer
