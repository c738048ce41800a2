// SPDX-License-Identifier: MIT
// Training progress on stderr: one line redrawn in place on a terminal, a sparse log elsewhere.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "trainer/app/terminal/status_line.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// Returns bar, step, loss, RMSE, eigenvalues, rate and time left in at most `columns` terminal columns. If there is
/// not enough room, the eigenvalues are left out first, then the rate. Without `utf8` the text is ASCII.
std::string progress_bar_line(const TrainProgress& progress, std::size_t columns, bool utf8);

/// Describes the progress in words, for a log.
std::string progress_log_line(const TrainProgress& progress, bool utf8);

/// Returns "-0.26±0.92i, -1.3": a complex pair once, whether one or both of its members are listed.
std::string eigenvalues_text(const std::vector<std::complex<double>>& eigenvalues, bool utf8);

/// Returns "8 s", "2:05", "1:02:05"; "?" if the time is not known.
std::string duration_text(double seconds);

/// Returns a bar of `cells` columns, in eighths of a cell if `utf8` allows it; `share` in [0, 1].
std::string progress_bar(double share, std::size_t cells, bool utf8);

/// Returns the first `columns` terminal columns of `text`.
std::string shortened(const std::string& text, std::size_t columns);

class ProgressDisplay {
 public:
  using Mode = StatusLine::Mode;

  explicit ProgressDisplay(std::FILE* stream = stderr) : line_(stream) {}
  ProgressDisplay(std::FILE* stream, Mode mode, bool utf8, std::size_t columns = 0)
      : line_(stream, mode, utf8, columns) {}

  /// May be called as often as you like: see StatusLine.
  void update(const TrainProgress& progress);

  /// Ends the redrawn line, with its latest state on it, so that other text can follow.
  void finish() { line_.finish(); }

 private:
  StatusLine line_;
};

}  // namespace nlo::trainer
