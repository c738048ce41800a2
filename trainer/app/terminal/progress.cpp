// SPDX-License-Identifier: MIT
#include "trainer/app/terminal/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kWidestBar = 30, kNarrowestBar = 6;

double share(const TrainProgress& progress) {
  if (progress.steps <= 0) return 0.0;
  return std::clamp(static_cast<double>(progress.step) / static_cast<double>(progress.steps), 0.0, 1.0);
}

std::string rate_text(double steps_per_s) {
  return fmt::format("{} steps/s", significant(steps_per_s));
}

std::string number_text(double value) {
  return std::isfinite(value) ? significant(value) : "?";
}

}  // namespace

std::string progress_bar(double share, std::size_t cells, bool utf8) {
  std::string text;
  if (!utf8) {
    const auto full = static_cast<std::size_t>(share * static_cast<double>(cells));
    return fmt::format("[{:#<{}}{:.<{}}]", "", full, "", cells - full);
  }
  // Eighths of a cell, so that the progress of slow runs is visible.
  constexpr std::string_view kPartial[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const auto eighths = static_cast<std::size_t>(share * static_cast<double>(8 * cells));
  std::size_t drawn = eighths / 8;
  for (std::size_t i = 0; i < drawn; ++i) text += "█";
  if (eighths % 8 != 0) {
    text += kPartial[eighths % 8];
    ++drawn;
  }
  for (; drawn < cells; ++drawn) text += "░";
  return text;
}

std::string shortened(const std::string& text, std::size_t columns) {
  if (display_width(text) <= columns) return text;
  std::size_t end = 0;
  for (std::size_t next = 0; next <= text.size(); ++next) {
    const bool boundary = next == text.size() || (static_cast<unsigned char>(text[next]) & 0xc0) != 0x80;
    if (!boundary) continue;
    if (display_width(std::string_view(text).substr(0, next)) > columns) break;
    end = next;
  }
  return text.substr(0, end);
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0.0 || seconds > 1e9) return "?";
  const auto whole = static_cast<long>(std::lround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string eigenvalues_text(const std::vector<std::complex<double>>& eigenvalues, bool utf8) {
  constexpr int kDigits = 2;
  std::string text;
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    const std::complex<double> value = eigenvalues[i];
    if (i > 0 && value.imag() != 0.0 && value == std::conj(eigenvalues[i - 1])) continue;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", significant(value.real(), kDigits));
    if (value.imag() != 0.0)
      text += fmt::format("{}{}i", utf8 ? "±" : "+-", significant(std::abs(value.imag()), kDigits));
  }
  return text;
}

std::string progress_bar_line(const TrainProgress& progress, std::size_t columns, bool utf8) {
  const int digits = static_cast<int>(fmt::formatted_size("{}", progress.steps));
  const std::string count = fmt::format(" {:>{}}/{}", progress.step, digits, progress.steps);
  const std::string errors = fmt::format("  loss {}  rmse {}", number_text(progress.loss), number_text(progress.rmse));
  const std::string left = progress.step >= progress.steps ? fmt::format("  in {}", duration_text(progress.elapsed_s))
                                                           : fmt::format("  {} left", duration_text(progress.left_s));
  const std::string rate = progress.steps_per_s > 0.0 ? fmt::format("  {}", rate_text(progress.steps_per_s)) : "";
  const std::string lambda = progress.eigenvalues.empty() ? ""
                                                          : fmt::format("  {} {}", utf8 ? "λ" : "eigenvalues",
                                                                        eigenvalues_text(progress.eigenvalues, utf8));

  // Texts after the bar, from the longest to the shortest. The first that leaves room for a bar is used.
  const std::string versions[] = {count + errors + lambda + rate + left, count + errors + rate + left,
                                  count + errors + left, count + errors};
  const std::size_t brackets = utf8 ? 0 : 2;
  for (const std::string& version : versions) {
    const std::size_t taken = display_width(version) + brackets;
    if (taken + kNarrowestBar > columns) continue;
    return progress_bar(share(progress), std::min(kWidestBar, columns - taken), utf8) + version;
  }
  return shortened(count.substr(1) + errors, columns);
}

std::string progress_log_line(const TrainProgress& progress, bool utf8) {
  std::string text = fmt::format("step {} of {}: loss {}, rmse {}", progress.step, progress.steps,
                                 number_text(progress.loss), number_text(progress.rmse));
  if (!progress.eigenvalues.empty())
    text += fmt::format(", eigenvalues {}", eigenvalues_text(progress.eigenvalues, utf8));
  if (progress.steps_per_s > 0.0) text += fmt::format(", {}", rate_text(progress.steps_per_s));
  return text + (progress.step >= progress.steps ? fmt::format(", took {}", duration_text(progress.elapsed_s))
                                                 : fmt::format(", {} left", duration_text(progress.left_s)));
}

void ProgressDisplay::update(const TrainProgress& progress) {
  line_.update(
      share(progress), progress.step >= progress.steps,
      [progress](std::size_t columns, bool utf8) { return progress_bar_line(progress, columns, utf8); },
      [&progress](bool utf8) { return progress_log_line(progress, utf8); });
}

}  // namespace nlo::trainer
