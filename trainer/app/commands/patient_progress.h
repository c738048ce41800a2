// SPDX-License-Identifier: MIT
// Progress on stderr for work that is usually short: at once on a terminal; elsewhere only after two seconds, so that
// the log of a quick command stays empty.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <string>

#include "trainer/app/terminal/progress.h"
#include "trainer/app/terminal/status_line.h"

namespace nlo::trainer {

constexpr std::chrono::seconds kPatience{2};

class PatientProgress {
 public:
  PatientProgress() { line_.log_after(kPatience); }

  /// `share`: finished share of the work, in [0, 1]; `what`: the current work.
  void update(double share, const std::string& what) {
    line_.update(
        share, share >= 1.0,
        [share, what](std::size_t columns, bool utf8) {
          constexpr std::size_t kCells = 20;
          return shortened(fmt::format("{} {:3.0f} % {}", progress_bar(share, kCells, utf8), 100.0 * share, what),
                           columns);
        },
        [share, what](bool) { return fmt::format("{:.0f} %: {}", 100.0 * share, what); });
  }

  /// Ends the progress line. Call it before anything else is printed.
  void finish() { line_.finish(); }

 private:
  StatusLine line_;
};

}  // namespace nlo::trainer
