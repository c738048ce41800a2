// SPDX-License-Identifier: MIT
// One progress bar over many trainings and other work, weighted by their costs. Safe to call from
// several threads.
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

/// Bar, share, models, time left and current work, in at most `columns` terminal columns.
std::string jobs_bar_line(const JobsState& state, std::size_t columns, bool utf8);

/// Describes the state in words, for a log.
std::string jobs_log_line(const JobsState& state);

class JobsProgress {
 public:
  /// A log gets a line every half a minute, or when another tenth is done.
  explicit JobsProgress(StatusLine& line);

  /// Adds work, before it starts, of which `models` are to be trained; both negative: it needs not be done.
  void expect(double cost_s, int models = 0);

  /// This much of it is done.
  void advance(double cost_s, const std::string& doing);

  /// A model is trained, with the last `cost_s` of its work.
  void model_done(double cost_s, const std::string& name);

  /// All done: the last line.
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
