// SPDX-License-Identifier: MIT
#include "trainer/reproduce/run_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/evaluation/text.h"
#include "trainer/terminal/progress.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::size_t kWidestBar = 30, kNarrowestBar = 6;

std::string percent(double share) {
  return fmt::format("{:.0f} %", std::floor(100.0 * share));
}

std::string models_text(const RunState& state) {
  return state.models == 0 ? "" : fmt::format("{}/{} models", state.models_done, state.models);
}

std::string time_text(const RunState& state) {
  constexpr double kTooEarlyToTell = 0.01;
  if (state.share >= 1.0) return "took " + duration_text(state.elapsed_s);
  return state.share < kTooEarlyToTell ? "" : duration_text(state.left_s) + " left";
}

}  // namespace

std::string run_bar_line(const RunState& state, std::size_t columns, bool utf8) {
  std::string facts = fmt::format(" {:>5}", percent(state.share));
  if (state.models > 0) facts += "  " + models_text(state);
  if (const std::string time = time_text(state); !time.empty()) facts += "  " + time;
  const std::size_t taken = display_width(facts) + (utf8 ? 0 : 2);
  if (taken + kNarrowestBar > columns) return shortened(facts.substr(1), columns);
  const std::string line = progress_bar(state.share, std::min(kWidestBar, columns - taken), utf8) + facts;
  return shortened(line + "  " + state.doing, columns);
}

std::string run_log_line(const RunState& state) {
  std::string text = percent(state.share);
  if (state.models > 0) text += ", " + models_text(state);
  if (const std::string time = time_text(state); !time.empty()) text += ", " + time;
  return state.doing.empty() ? text : text + ": " + state.doing;
}

RunProgress::RunProgress(StatusLine& line) : line_(line) {
  line_.log_every(std::chrono::seconds(30));
}

void RunProgress::expect(double cost_s) {
  const std::lock_guard lock(mutex_);
  expected_s_ += cost_s;
}

void RunProgress::models(int count) {
  const std::lock_guard lock(mutex_);
  state_.models = count;
}

void RunProgress::advance(double cost_s, const std::string& doing) {
  const std::lock_guard lock(mutex_);
  done_s_ += cost_s;
  state_.doing = doing;
  show(false);
}

void RunProgress::model_done(const std::string& name) {
  const std::lock_guard lock(mutex_);
  ++state_.models_done;
  state_.doing = "trained " + name;
  show(false);
}

void RunProgress::finish() {
  const std::lock_guard lock(mutex_);
  done_s_ = expected_s_ = 1.0;
  state_.doing.clear();
  show(true);
}

void RunProgress::show(bool last) {
  state_.share = expected_s_ > 0.0 ? std::clamp(done_s_ / expected_s_, 0.0, 1.0) : 0.0;
  if (!last) state_.share = std::min(state_.share, 0.999);  // 100 % is said once, when it is true
  state_.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  state_.left_s = state_.elapsed_s * (1.0 - state_.share) / std::max(state_.share, 1e-6);
  line_.update(
      state_.share, last,
      [state = state_](std::size_t columns, bool utf8) { return run_bar_line(state, columns, utf8); },
      [this](bool) { return run_log_line(state_); });
}

}  // namespace nlo::trainer::reproduction
