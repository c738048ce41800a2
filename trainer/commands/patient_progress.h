// SPDX-License-Identifier: MIT
// Progress on stderr for work that is mostly short: at once on a terminal, elsewhere only once it has taken two
// seconds, so that the log of a quick command stays empty.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "trainer/terminal/progress.h"
#include "trainer/terminal/status_line.h"

namespace nlo::trainer {

class PatientProgress {
 public:
  ~PatientProgress() { finish(); }

  /// `share` in [0, 1] of the work is done; `what` is being worked on.
  void update(double share, const std::string& what) {
    using std::chrono::steady_clock;
    if (!terminal_ && steady_clock::now() - started_ < std::chrono::seconds(2)) return;
    if (!line_) line_.emplace(stderr);
    line_->update(
        share, share >= 1.0,
        [share, what](std::size_t columns, bool utf8) {
          constexpr std::size_t kCells = 20;
          return shortened(fmt::format("{} {:3.0f} % {}", progress_bar(share, kCells, utf8), 100.0 * share, what),
                           columns);
        },
        [share, what](bool) { return fmt::format("{:.0f} %: {}", 100.0 * share, what); });
  }

  /// Before anything else is printed.
  void finish() {
    if (line_) line_->finish();
    line_.reset();
  }

 private:
  bool terminal_ = ::isatty(::fileno(stderr)) == 1;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::optional<StatusLine> line_;
};

}  // namespace nlo::trainer
