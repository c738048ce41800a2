// SPDX-License-Identifier: MIT
// Training progress on stderr: one line redrawn in place on a terminal, a sparse log elsewhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>

#include "trainer/train.h"

namespace nlo::trainer {

/// Bar, step, loss, RMSE, eigenvalues, rate and time left in at most `columns` terminal columns: the eigenvalues go
/// first when room is short, the rate next. Without `utf8` the text is ASCII.
std::string progress_bar_line(const TrainProgress& progress, std::size_t columns, bool utf8);

/// The same facts in words, for a log.
std::string progress_log_line(const TrainProgress& progress, bool utf8);

/// "-0.26±0.92i, -1.3": a complex pair once, whether one or both of its members are listed.
std::string eigenvalues_text(const std::vector<std::complex<double>>& eigenvalues, bool utf8);

/// "8 s", "2:05", "1:02:05"; "?" when it is not known.
std::string duration_text(double seconds);

class ProgressDisplay {
 public:
  enum class Mode { kTerminal, kLog, kSilent };

  /// The mode that fits the stream: a terminal that is not dumb is redrawn, everything else gets a log.
  explicit ProgressDisplay(std::FILE* stream = stderr);
  ProgressDisplay(std::FILE* stream, Mode mode, bool utf8, std::size_t columns = 0);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  /// Call as often as you like: the terminal is redrawn at most 10 times a second; a log gets a line when 5 s have
  /// passed or another tenth of the steps is done, and always at the first and the last step.
  void update(const TrainProgress& progress);

  /// Ends the redrawn line, with its latest state on it, so that other text can follow.
  void finish();

 private:
  std::size_t columns() const;
  void draw();

  std::FILE* stream_;
  Mode mode_;
  bool utf8_;
  std::size_t fixed_columns_;
  TrainProgress latest_;
  bool open_ = false;   ///< the cursor stands in a line of ours
  bool stale_ = false;  ///< latest_ is newer than what is on screen
  bool started_ = false;
  long last_logged_tenth_ = -1;
  std::chrono::steady_clock::time_point last_output_;
};

}  // namespace nlo::trainer
