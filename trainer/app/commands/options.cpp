// SPDX-License-Identifier: MIT
#include "trainer/app/commands/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "trainer/base/number_text.h"

namespace nlo::trainer {

std::string check_seed(const std::string& text) {
  constexpr std::size_t kMostDigits = 18;  // TOML's integers are below 2^63
  const bool is_whole = std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!text.empty() && is_whole && text.size() <= kMostDigits) return "";
  return fmt::format("{} is not a seed; write an integer of at least 0 with at most {} digits", text, kMostDigits);
}

std::string check_scale(const std::string& text) {
  constexpr double kSmallest = 1e-6, kLargest = 1e6;
  const auto number = finite_number(text);
  if (number && *number >= kSmallest && *number <= kLargest) return "";
  return fmt::format("{} is not a scale; write a number from {} to {}", text, kSmallest, kLargest);
}

std::string check_minutes(const std::string& text) {
  constexpr double kShortest = 0.05, kLongest = 1e5;
  const auto number = finite_number(text);
  if (number && *number >= kShortest && *number <= kLongest) return "";
  return fmt::format("{} is not a valid time for the search; write minutes from {} to {}", text, kShortest, kLongest);
}

void Options::experiment(ExperimentArgument& to) {
  changes(to.overrides);
  value("--seed", to.seed, "seed that replaces the seed of the file")->check(check_seed);
  value("--threads", to.threads, kThreads);
}

}  // namespace nlo::trainer
