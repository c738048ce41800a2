// SPDX-License-Identifier: MIT
// One progress bar for many trainings and other work, weighted by their costs. Several threads may call it.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

#include "trainer/app/terminal/status_line.h"

namespace nlo::trainer {

/// The state of all jobs at one moment.
struct JobsState {
  double share = 0.0;  ///< finished share of the work, in [0, 1]
  int models_done = 0, models = 0;
  std::string doing;
  double elapsed_s = 0.0, left_s = 0.0;
};

/// Returns a bar, share, models, time left and current work, in at most `columns` terminal columns.
std::string jobs_bar_line(const JobsState& state, std::size_t columns, bool utf8);

/// Describes the state in words, for a log.
std::string jobs_log_line(const JobsState& state);

class JobsProgress {
 public:
  /// If stderr is not a terminal, writes a line every half a minute, and when another tenth is done.
  explicit JobsProgress(StatusLine& line);

  /// Adds work before it starts. `models`: number of models to be trained. Both negative: the work is not needed.
  void expect(double cost_s, int models = 0);

  /// Marks work of this cost as done.
  void advance(double cost_s, const std::string& doing);

  /// Marks a model as trained; `cost_s` is the last part of its work.
  void model_done(double cost_s, const std::string& name);

  /// Shows the last line.
  void finish();

 private:
  void show(bool last);

  StatusLine& line_;
  std::mutex mutex_;
  double expected_s_ = 0.0, done_s_ = 0.0;
  JobsState state_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace nlo::trainer
