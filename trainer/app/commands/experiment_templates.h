// SPDX-License-Identifier: MIT
// The text of a new experiment file.
#pragma once

#include <cstddef>
#include <string>

#include "trainer/data/guess/log_guess.h"

namespace nlo::trainer {

/// An experiment with a plant by equations, complete, with further keys as comments.
///   name  of the experiment, an identifier
///   file  where it is written, for its comments
std::string plant_template(const std::string& name, const std::string& file);

/// The text of an experiment from guesses about logs, with their reasons.
///   command  the command that made it
///   train    the command to continue with
std::string log_template(const GuessedLog& log, const std::string& name, const std::string& command,
                         const std::string& train);

/// "no file", "1 file", "3 files".
std::string files_text(std::size_t count);

/// How even the stamps of a clock are, in words.
std::string evenness_text(const GuessedClock& clock);

}  // namespace nlo::trainer
