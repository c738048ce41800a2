// SPDX-License-Identifier: MIT
// "Did you mean ...?": finds the known name that needs the fewest edits (insert, delete, replace; Levenshtein) from a
// wrong one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

/// Returns the name in `known` that is nearest to `wrong`; among equals the first. Returns an empty text if `known` is
/// empty or the nearest name shares less than half of its letters with `wrong`, because such a guess misleads.
inline std::string nearest_name(std::string_view wrong, const std::vector<std::string>& known) {
  std::size_t best_distance = 0;
  const std::string* best = nullptr;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(wrong, name);
    if (best == nullptr || distance < best_distance) best = &name, best_distance = distance;
  }
  return best != nullptr && 2 * best_distance <= std::max(wrong.size(), best->size()) ? *best : std::string();
}

}  // namespace nlo::trainer
