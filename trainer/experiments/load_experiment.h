// SPDX-License-Identifier: MIT
// Reads an experiment file into a checked value, and writes it back as text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/config/places.h"

namespace nlo::trainer {

/// An experiment whose file may leave out the eigenvalues of a KKL observer, or [training] steps of an observer with
/// gated units or with a prior. Then a recipe derives them, and all other keys that are missing, from the training data
/// (choose/recipe.h).
struct DraftExperiment {
  Experiment experiment;  ///< passes all checks; if eigenvalues are missing, substitutes stand in their place until a
                          ///< recipe derives them
  Places given;           ///< the keys of the file and of --set; a recipe does not change them
  bool complete = true;
};

/// Reads and checks an experiment file that may be a draft. Arguments and errors are those of read_experiment. The
/// source_text of a draft distinguishes it from other drafts and is not recorded.
DraftExperiment read_draft(const std::string& path, const std::vector<std::string>& overrides = {});

/// Reads a draft from text. Messages name `filename`.
DraftExperiment parse_draft(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides = {});

/// Reads and checks an experiment file. Missing keys have their defaults. `overrides` are "section.key=value" with a
/// TOML value (--set) and are applied after the file. Throws codegen::Error: `FILE:LINE: reason; remedy`.
Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides = {});

/// Reads an experiment from text. Messages name `filename`.
Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides = {});

/// Returns the experiment with which a model was trained. `origin` names the model's file. Throws codegen::Error if the
/// model has none.
Experiment experiment_of(const codegen::Model& model, const std::string& origin);

/// Returns the [log] of a file that only has the roles of columns: [[log.columns]] and the keys that belong to them.
/// Throws codegen::Error as read_experiment does.
LogConfig read_log_columns(const std::string& path);

/// Returns every key with its value as TOML. Equal experiments give equal texts, however their files are written.
/// `threads` is left out, because it does not affect the result.
std::string format_experiment(const Experiment& experiment);

/// Returns a draft of the experiment: its data, its structure, how inputs act, and its evaluation. A recipe derives the
/// other keys.
std::string format_draft(const Experiment& experiment);

/// Returns a text for users with every key of an experiment file, its type, default and meaning.
std::string describe_experiment_keys();

}  // namespace nlo::trainer
