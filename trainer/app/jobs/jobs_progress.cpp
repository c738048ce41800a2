// SPDX-License-Identifier: MIT
#include "trainer/app/jobs/jobs_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/app/terminal/progress.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kWidestBar = 30, kNarrowestBar = 6;

std::string whole_percent(double share) {
  return fmt::format("{:.0f} %", std::floor(100.0 * share));
}

std::string models_text(const JobsState& state) {
  return state.models == 0 ? "" : fmt::format("{}/{} models", state.models_done, state.models);
}

std::string time_text(const JobsState& state) {
  constexpr double kTooEarlyToTell = 0.01;
  if (state.share >= 1.0) return "took " + duration_text(state.elapsed_s);
  return state.share < kTooEarlyToTell ? "" : duration_text(state.left_s) + " left";
}

}  // namespace

std::string jobs_bar_line(const JobsState& state, std::size_t columns, bool utf8) {
  std::string facts = fmt::format(" {:>5}", whole_percent(state.share));
  if (state.models > 0) facts += "  " + models_text(state);
  if (const std::string time = time_text(state); !time.empty()) facts += "  " + time;
  const std::size_t taken = display_width(facts) + (utf8 ? 0 : 2);
  if (taken + kNarrowestBar > columns) return shortened(facts.substr(1), columns);
  const std::string line = progress_bar(state.share, std::min(kWidestBar, columns - taken), utf8) + facts;
  return shortened(line + "  " + state.doing, columns);
}

std::string jobs_log_line(const JobsState& state) {
  std::string text = whole_percent(state.share);
  if (state.models > 0) text += ", " + models_text(state);
  if (const std::string time = time_text(state); !time.empty()) text += ", " + time;
  return state.doing.empty() ? text : text + ": " + state.doing;
}

JobsProgress::JobsProgress(StatusLine& line) : line_(line) {
  line_.log_every(std::chrono::seconds(30));
}

void JobsProgress::expect(double cost_s, int models) {
  const std::lock_guard lock(mutex_);
  expected_s_ += cost_s;
  state_.models += models;
}

void JobsProgress::advance(double cost_s, const std::string& doing) {
  const std::lock_guard lock(mutex_);
  done_s_ += cost_s;
  state_.doing = doing;
  show(false);
}

void JobsProgress::model_done(double cost_s, const std::string& name) {
  const std::lock_guard lock(mutex_);
  done_s_ += cost_s;
  ++state_.models_done;
  state_.doing = "trained " + name;
  show(false);
}

void JobsProgress::finish() {
  const std::lock_guard lock(mutex_);
  done_s_ = expected_s_ = 1.0;
  state_.doing.clear();
  show(true);
}

void JobsProgress::show(bool last) {
  state_.share = expected_s_ > 0.0 ? std::clamp(done_s_ / expected_s_, 0.0, 1.0) : 0.0;
  if (!last) state_.share = std::min(state_.share, 0.999);  // only the last line shows 100 %
  state_.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  state_.left_s = state_.elapsed_s * (1.0 - state_.share) / std::max(state_.share, 1e-6);
  line_.update(
      state_.share, last,
      [state = state_](std::size_t columns, bool utf8) { return jobs_bar_line(state, columns, utf8); },
      [this](bool) { return jobs_log_line(state_); });
}

}  // namespace nlo::trainer
