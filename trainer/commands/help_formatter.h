// SPDX-License-Identifier: MIT
// --help as wide as the terminal, with types and ranges in words.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>

namespace nlo::trainer {

/// Columns for text on stdout: those of its terminal, or of the environment's COLUMNS,
/// 100 where neither is known; 60 at least.
std::size_t help_width();

/// `text` with line breaks in place of spaces, no line longer than `width` but for a word that is;
/// breaks that it has stay.
std::string wrapped(const std::string& text, std::size_t width);

/// CLI11's own help with its right column wrapped, and "INT=20" with "1 to 100" behind the description in place of
/// "INT:INT in [1 - 100]=20".
class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(std::size_t width) : width_(width) {}

  std::string make_description(const CLI::App* command) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_footer(
      const CLI::App* command) const override;  ///< examples, which are indented, stay on their lines

 private:
  std::string right_column(const std::string& text) const;

  std::size_t width_;
};

}  // namespace nlo::trainer
