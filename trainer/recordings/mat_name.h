// SPDX-License-Identifier: MIT
// The names that MATLAB has for parts of variables.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer {

/// One part of "out.signals(2).values(3)".
struct MatStep {
  std::string name;
  std::size_t index = 0;  ///< from 1; 0: none was written
};

/// Nothing where it is not such a name.
inline std::optional<std::vector<MatStep>> mat_steps(const std::string& heading) {
  std::vector<MatStep> steps;
  for (std::size_t from = 0; from <= heading.size();) {
    const std::size_t end = std::min(heading.find('.', from), heading.size());
    std::string part = heading.substr(from, end - from);
    MatStep step;
    if (const std::size_t open = part.find('('); open != std::string::npos && part.ends_with(')')) {
      const char* last = part.data() + part.size() - 1;
      if (std::from_chars(part.data() + open + 1, last, step.index).ptr != last || step.index == 0) return std::nullopt;
      part.resize(open);
    }
    if (part.empty()) return std::nullopt;
    step.name = part;
    steps.push_back(step);
    from = end + 1;
  }
  return steps;
}

}  // namespace nlo::trainer
