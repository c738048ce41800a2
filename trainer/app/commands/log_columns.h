// SPDX-License-Identifier: MIT
// Which columns of a log a model is evaluated on: those of its own experiment, of a table in a file, or those whose
// headings are the names of its channels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// `file` (--columns) decides if it is not empty; else the experiment's [log]; else, for a model of a plant, the
/// heading of each output and state is its name and that of the time [s] is "time". Without a column of time and a
/// period of their own, rows are the model's sample period apart. A column that has the name of a channel and another
/// unit of the same kind converts to the channel's; a unit that is not known is in `notes`, and nothing converts.
/// Throws codegen::Error as read_log_columns does; for a column whose unit is of another kind than the channel's.
LogConfig columns_for(const codegen::Model& model, const Experiment& experiment, const std::string& file,
                      std::vector<std::string>& notes);

/// Takes the states out of `log` whose column one of the files (names or globs) does not have: they are estimated, and
/// not scored. Throws codegen::Error where none is left, or a pattern matches no file.
void leave_out_absent_truth(LogConfig& log, const std::vector<std::string>& files);

/// The logs that `model` was trained on, read by `columns`, where they lie in the folder of the first of `files`;
/// nothing where one is missing or has other rows: then alternatives can only be fitted in hindsight.
std::optional<Dataset> training_logs_beside(const codegen::Model& model, const Experiment& experiment,
                                            const LogConfig& columns, const std::vector<std::string>& files);

}  // namespace nlo::trainer
