// SPDX-License-Identifier: MIT
// From an experiment file to a checked value and back to text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Reads and checks an experiment file. `overrides` are "section.key=value" with a TOML value (--set); they come after
/// the file. Throws codegen::Error: `FILE:LINE: what is wrong; what to do`.
Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same from text; `filename` stands for the file in messages.
Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides = {});

/// The [log] of a file that says which columns of a log are what: [[log.columns]] and what goes with them, and nothing
/// else. Throws codegen::Error as read_experiment does.
LogConfig read_log_columns(const std::string& path);

/// Every key with its value, as TOML: the same text for the same experiment, whatever its file looked like. `threads`
/// is left out, as it decides nothing.
std::string format_experiment(const Experiment& experiment);

/// Every key of an experiment file with its type, default and meaning, for people.
std::string describe_experiment_keys();

}  // namespace nlo::trainer
