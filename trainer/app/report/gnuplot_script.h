// SPDX-License-Identifier: MIT
// Figures as gnuplot commands and the data files that they read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "trainer/app/report/gnuplot.h"

namespace nlo::trainer {

/// The commands that draw `figure` into NUMBER.svg; its data go to files in `directory`. `written` becomes false if one
/// of them cannot be written.
std::string figure_script(const Figure& figure, std::size_t number, const std::filesystem::path& directory,
                          bool& written);

/// False when the file cannot be written.
bool write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace nlo::trainer
