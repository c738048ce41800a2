// SPDX-License-Identifier: MIT
// Expressions evaluated side by side, what they have in common once.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "codegen/model/expression.h"

namespace nlo::codegen {

/// Expressions whose common parts are evaluated once: reading `first` + k of the rows, and of later parts, is parts[k].
struct SharedExpressions {
  static constexpr std::size_t kMostParts = 128;
  std::vector<Expression> parts, rows;

  SharedExpressions() = default;
  /// `first`: how many readings there are.
  SharedExpressions(const std::vector<Expression>& all, int first);

  /// The values of the rows where reading j is reading(j).
  template <class Value, class Reading>
  void evaluate(const Reading& reading, Value* values) const {
    std::array<Value, kMostParts> shared;
    const auto all = [&](int j) { return j < first_ ? reading(j) : shared[static_cast<std::size_t>(j - first_)]; };
    for (std::size_t k = 0; k < parts.size(); ++k) shared[k] = parts[k].template evaluate<Value>(all);
    for (const Expression& row : rows) *values++ = row.template evaluate<Value>(all);
  }

 private:
  int first_ = 0;
};

}  // namespace nlo::codegen
