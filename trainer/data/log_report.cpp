// SPDX-License-Identifier: MIT
#include "trainer/data/log_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace nlo::trainer {

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
  for (const std::string& line : report.notes) text += "note: " + line + "\n";
  return text;
}

}  // namespace nlo::trainer
