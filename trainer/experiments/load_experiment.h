// SPDX-License-Identifier: MIT
// From an experiment file to a checked value and back to text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/config/places.h"

namespace nlo::trainer {

/// An experiment whose file may leave out the observer's eigenvalues, and with them all keys that a recipe derives
/// from the training data (choose/recipe.h).
struct DraftExperiment {
  Experiment experiment;  ///< passes all checks; where it is not complete, by eigenvalues that stand in until derived
  Places given;           ///< the keys of the file and of --set, which are not derived
  bool complete = true;
};

/// Reads and checks an experiment file that may be a draft. Arguments and errors: see read_experiment. The source_text
/// of a draft distinguishes it from others and is not recorded.
DraftExperiment read_draft(const std::string& path, const std::vector<std::string>& overrides = {});

/// Reads a draft from text; messages name `filename`.
DraftExperiment parse_draft(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides = {});

/// Reads and checks an experiment file. `overrides` are "section.key=value" with a TOML value (--set); they come after
/// the file. Throws codegen::Error: `FILE:LINE: reason; remedy`.
Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides = {});

/// Reads an experiment from text; messages name `filename`.
Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides = {});

/// The experiment a model was trained by. `origin` names the model's file. Throws codegen::Error when it has none.
Experiment experiment_of(const codegen::Model& model, const std::string& origin);

/// The [log] of a file that only has the roles of columns: [[log.columns]] and the keys that belong to them. Throws
/// codegen::Error as read_experiment does.
LogConfig read_log_columns(const std::string& path);

/// Every key with its value, as TOML: the same text for the same experiment, for any form of its file. `threads` is
/// left out, because it does not affect the result.
std::string format_experiment(const Experiment& experiment);

/// Every key of an experiment file with its type, default and meaning, for people.
std::string describe_experiment_keys();

}  // namespace nlo::trainer
