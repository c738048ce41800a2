// SPDX-License-Identifier: MIT
// Chooses the columns of a log for the evaluation of a model: those of its own experiment, those of a table in a file,
// or those whose headings are the names of its channels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Returns the columns of `file` (--columns) if it is not empty; otherwise the experiment's [log]; otherwise, for a
/// model of a plant, columns whose headings are the names of outputs and states, and "time" [s]. Without a column of
/// time and a period of their own, rows have the model's sample period. A column with the name of a channel and another
/// unit of the same kind is converted to the unit of the channel. `notes` name units that are not known; their columns
/// are not converted. Throws codegen::Error like read_log_columns, and for a column whose unit is of another kind.
LogConfig columns_for(const codegen::Model& model, const Experiment& experiment, const std::string& file,
                      std::vector<std::string>& notes);

/// Removes the states from `log` whose column is missing in one of the files (names or globs). These states are
/// estimated but not scored. Throws codegen::Error if no state is left, or if a pattern matches no file.
void leave_out_absent_truth(LogConfig& log, const std::vector<std::string>& files);

/// Returns the logs on which `model` was trained, read by `columns`, if they are in the folder of the first of `files`.
/// Returns nothing if one is missing or has other rows; then alternatives can only be fitted in hindsight.
std::optional<Dataset> training_logs_beside(const codegen::Model& model, const Experiment& experiment,
                                            const LogConfig& columns, const std::vector<std::string>& files);

}  // namespace nlo::trainer
