// SPDX-License-Identifier: MIT
// Figures as gnuplot commands and data files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "trainer/app/report/gnuplot.h"

namespace nlo::trainer {

/// Returns the commands that draw `figure` into NUMBER.svg. Its data go to files in `directory`. `written` becomes
/// false if one of them cannot be written.
std::string figure_script(const Figure& figure, std::size_t number, const std::filesystem::path& directory,
                          bool& written);

/// Returns false if the file cannot be written.
bool write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace nlo::trainer
