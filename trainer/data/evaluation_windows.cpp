// SPDX-License-Identifier: MIT
#include "trainer/data/evaluation_windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

/// Rounds down to two digits, so that a window that must fit into the horizon still does.
double two_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  // 16 / 0.1 may give 159.99...; the factor corrects this rounding.
  const double units = std::floor(value / unit * (1.0 + 1e-9));
  return unit < 1.0 ? units / std::round(1.0 / unit) : units * unit;
}

double transient_length_s(double decay_rate, double horizon_s) {
  constexpr double kTimeConstants = 5.0;
  return decay_rate > 0.0 ? std::min(kTimeConstants / decay_rate, 0.5 * horizon_s) : 0.2 * horizon_s;
}

}  // namespace

EvaluationWindows whole_run() {
  return {{"all", 0.0, std::numeric_limits<double>::infinity()}};
}

EvaluationWindows evaluation_windows(const EvaluationConfig& evaluation, double decay_rate, double horizon_s) {
  EvaluationWindows windows = whole_run();
  if (!evaluation.windows.empty()) {
    windows.insert(windows.end(), evaluation.windows.begin(), evaluation.windows.end());
  } else if (horizon_s > 0.0) {
    const double t_c = two_digits(transient_length_s(decay_rate, horizon_s));
    windows.push_back({"transient", 0.0, t_c});
    windows.push_back({"settled", t_c, std::numeric_limits<double>::infinity()});
  }
  return windows;
}

std::size_t settled_window(const EvaluationWindows& windows) {
  for (std::size_t i = 1; i < windows.size(); ++i)
    if (!std::isfinite(windows[i].to_s)) return i;
  return 0;
}

double settled_from_s(const EvaluationWindows& windows) {
  return windows[settled_window(windows)].from_s;
}

double settling_window_s(const EvaluationConfig& evaluation, const EvaluationWindows& windows, double horizon_s) {
  if (evaluation.settling_window_s > 0.0) return evaluation.settling_window_s;
  const double from_s = settled_from_s(windows);
  return from_s > 0.0 ? from_s / 10.0 : horizon_s / 50.0;
}

std::string window_text(const EvaluationWindow& window) {
  if (window.name == "all") return window.name;
  const std::string from = shortest_text(window.from_s), to = shortest_text(window.to_s);
  if (!std::isfinite(window.to_s)) return fmt::format("{} (t >= {} s)", window.name, from);
  if (window.from_s == 0.0) return fmt::format("{} (t < {} s)", window.name, to);
  return fmt::format("{} ({}-{} s)", window.name, from, to);
}

}  // namespace nlo::trainer
