// SPDX-License-Identifier: MIT
// Progress of long work: one line redrawn in place on a terminal, sparse lines in a log.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>

namespace nlo::trainer {

class StatusLine {
 public:
  enum class Mode { kTerminal, kLog, kSilent };
  using BarText = std::function<std::string(std::size_t columns, bool utf8)>;
  using LogText = std::function<std::string(bool utf8)>;

  /// Chooses the mode for the stream: a terminal that is not dumb is redrawn, everything else gets a log.
  explicit StatusLine(std::FILE* stream = stderr);
  StatusLine(std::FILE* stream, Mode mode, bool utf8, std::size_t columns = 0);
  ~StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// A log gets a line when this much time has passed, or another tenth is done.
  void log_every(std::chrono::steady_clock::duration pause) { log_every_ = pause; }

  /// A log gets nothing before this much time has passed, so that quick work leaves it empty.
  void log_after(std::chrono::steady_clock::duration patience) {
    log_from_ = std::chrono::steady_clock::now() + patience;
  }

  /// May be called as often as you like. The terminal is redrawn at most 10 times a second. A log gets a line when 5 s
  /// have passed or another tenth is done, and always at the first and the last call. The texts are made only when they
  /// are shown.
  ///   share  finished share, in [0, 1]
  ///   last   show this one at any time
  void update(double share, bool last, BarText bar, const LogText& log);

  /// Ends the redrawn line, with its latest state on it, so that other text can follow.
  void finish();

 private:
  std::size_t columns() const;
  void draw();

  std::FILE* stream_;
  Mode mode_;
  bool utf8_;
  std::size_t fixed_columns_;
  std::chrono::steady_clock::duration log_every_ = std::chrono::seconds(5);
  std::chrono::steady_clock::time_point log_from_;
  BarText latest_;
  bool open_ = false;   ///< the cursor is in a line of this class
  bool stale_ = false;  ///< latest_ is newer than the screen
  bool started_ = false;
  long last_logged_tenth_ = -1;
  std::chrono::steady_clock::time_point last_output_;
};

}  // namespace nlo::trainer
