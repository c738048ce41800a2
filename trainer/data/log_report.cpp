// SPDX-License-Identifier: MIT
#include "trainer/data/log_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace nlo::trainer {
namespace {

/// Breaks a note into lines of at most 120 columns. A word that is longer has a line of its own.
std::vector<std::string> lines_of(const std::string& note) {
  constexpr std::size_t kColumns = 120;
  const std::string indent(6, ' ');
  std::vector<std::string> lines = {"note:"};
  for (std::size_t at = 0; at < note.size();) {
    const std::size_t end = std::min(note.find(' ', at), note.size());
    const std::string word = note.substr(at, end - at);
    if (lines.back().size() + 1 + word.size() > kColumns && lines.back().size() > indent.size())
      lines.push_back(indent + word);
    else
      lines.back() += " " + word;
    at = end + 1;
  }
  return lines;
}

/// Returns the first notes, in at most 25 lines, and the number of the others.
std::string notes_text(const std::vector<std::string>& notes) {
  constexpr std::size_t kMostLines = 25;
  std::string text;
  std::size_t used = 0, shown = 0;
  for (; shown < notes.size(); ++shown) {
    const std::vector<std::string> lines = lines_of(notes[shown]);
    const bool is_last = shown + 1 == notes.size();
    if (used > 0 && used + lines.size() + (is_last ? 0 : 1) > kMostLines) break;
    used += lines.size();
    for (const std::string& line : lines) text += line + "\n";
  }
  if (shown < notes.size()) text += fmt::format("note: {} more notes are in report.html\n", notes.size() - shown);
  return text;
}

}  // namespace

void note_once(std::vector<std::string>& notes, const std::string& text) {
  if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
}

std::string to_text(const LogReport& report) {
  std::size_t width = 4;
  for (const TimeStampReport& file : report.files) width = std::max(width, named(file).size());
  std::string text =
      fmt::format("nominal sample period {:.4g} ms; steps between time stamps in ms:\n", 1e3 * report.sample_period_s);
  text += fmt::format("{:<{}}  samples  seconds   median     1 %    99 %     max  gaps > 1.5 periods  steps used\n",
                      "file", width);
  for (const TimeStampReport& file : report.files)
    text += fmt::format("{:<{}}  {:7}  {:7.2f}  {:7.3f} {:7.3f} {:7.3f} {:7.3f}  {:18}  {}\n", named(file), width,
                        file.samples, file.duration_s, 1e3 * file.median_s, 1e3 * file.p01_s, 1e3 * file.p99_s,
                        1e3 * file.max_s, file.gaps, file.nominal ? "nominal" : "as stamped");
  return text + notes_text(report.notes);
}

}  // namespace nlo::trainer
