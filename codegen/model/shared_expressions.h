// SPDX-License-Identifier: MIT
// Several expressions whose common parts are evaluated once.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "codegen/model/expression.h"

namespace nlo::codegen {

/// Expressions whose common parts are evaluated once. Reading `first` + k of the rows and of later parts is parts[k].
struct SharedExpressions {
  static constexpr std::size_t kMostParts = 512;
  std::vector<Expression> parts, rows;

  SharedExpressions() = default;
  /// first: number of readings.
  SharedExpressions(const std::vector<Expression>& all, int first);

  /// Returns the values of the rows; reading(j) is the value of reading j.
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
