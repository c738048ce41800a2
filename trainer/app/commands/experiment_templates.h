// SPDX-License-Identifier: MIT
// The text of a new experiment file.
#pragma once

#include <cstddef>
#include <string>

#include "trainer/data/guess/log_guess.h"

namespace nlo::trainer {

/// Returns a complete experiment with a plant by equations, with further keys as comments.
///   name  name of the experiment, an identifier
///   file  name of the experiment file, which its comments mention
std::string plant_template(const std::string& name, const std::string& file);

/// Returns the text of an experiment from guesses about logs, with their reasons.
///   command  the command that made it
///   train    the command to continue with
std::string log_template(const GuessedLog& log, const std::string& name, const std::string& command,
                         const std::string& train);

/// Returns "no file", "1 file", "3 files".
std::string files_text(std::size_t count);

/// Describes in words how regular the stamps of a clock are.
std::string evenness_text(const GuessedClock& clock);

}  // namespace nlo::trainer
