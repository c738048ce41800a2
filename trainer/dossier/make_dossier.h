// SPDX-License-Identifier: MIT
// The files of a dossier: each is what a command of this program prints or writes, run in a folder of its own, so that
// the command in the index gives the same bytes again.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/dossier/dossier_table.h"

namespace nlo::trainer {

/// What is known before anything runs.
struct DossierInput {
  std::string program;     ///< this program's file
  std::string sources;     ///< SHA-256 of what it was built from
  std::string model_text;  ///< the bytes of the model's file
  codegen::Model model;
  const Experiment* experiment = nullptr;  ///< null: the model does not say what trained it
  std::vector<std::string> logs;           ///< files, absolute; empty: none were given
  std::string tree;                        ///< nlo's source tree, absolute; empty: none was given
  std::string scalar;                      ///< of the export
  std::string data_hash;                   ///< of the training data as they are now; empty: not computed
};

/// An item as it came out.
struct DossierEntry {
  const DossierItem* item = nullptr;
  std::string what, again;  ///< for the reader; a command stands in backquotes, as a shell takes it
  std::string refusal;      ///< why it is not there; empty: it is
};

struct Dossier {
  std::vector<DossierEntry> entries;
  std::vector<codegen::NamedText> files;  ///< those of the items, and what their commands have written, by path
};

/// Makes every item of `table` that can be made. `before`: told what runs next. Throws codegen::Error where a command
/// fails that may not, with what it said.
Dossier make_dossier(const DossierInput& input, const DossierTable& table,
                     const std::function<void(const std::string& command)>& before);

/// `dossier` with its pages: index.md, evidence.md, and SHA256SUMS over all files.
std::vector<codegen::NamedText> with_pages(const DossierInput& input, const DossierTable& table, Dossier dossier);

}  // namespace nlo::trainer
