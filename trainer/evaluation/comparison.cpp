// SPDX-License-Identifier: MIT
#include "trainer/evaluation/comparison.h"

#include <fmt/format.h>

#include <cmath>

#include "trainer/evaluation/text.h"

namespace nlo::trainer {

std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states) {
  std::vector<std::string> notes;
  for (const ComparedState& state : states) {
    if (!std::isfinite(state.observer)) continue;
    const auto shown = [&](double error) { return significant(error) + (state.unit.empty() ? "" : " " + state.unit); };
    const auto is_no_better_than = [&](double other) {
      return std::isfinite(other) && state.observer >= kNoBetterThanConstant * other;
    };
    if (is_no_better_than(state.constant))
      notes.push_back(
          fmt::format("{} is not seen: its error, {}: {}, is no better than that of a constant, {}. These "
                      "outputs may not determine it.",
                      state.name, state.window, shown(state.observer), shown(state.constant)));
    else if (is_no_better_than(state.simple))
      notes.push_back(fmt::format("{} needs no network: its error, {}: {}, is no better than that of {}, {}.",
                                  state.name, state.window, shown(state.observer), state.simple_name,
                                  shown(state.simple)));
  }
  return notes;
}

}  // namespace nlo::trainer
