// SPDX-License-Identifier: MIT
// Several expressions, whose common parts are evaluated once.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "codegen/model/expression.h"

namespace nlo::codegen {

/// Expressions whose common parts are evaluated once: reading `first` + k of the rows, and of later parts, is parts[k].
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

  /// From the cotangents of the rows to those of the readings below `first`: added to `to`.
  template <class Value, class Reading>
  void pull_back(const Reading& reading, const Value* of_rows, Value* to) const {
    std::vector<Value> shared(parts.size()), to_shared(parts.size(), Value(0.0));
    const auto all = [&](int j) { return j < first_ ? reading(j) : shared[static_cast<std::size_t>(j - first_)]; };
    const auto take = [&](int j, const Value& cotangent) {
      Value& sum = j < first_ ? to[j] : to_shared[static_cast<std::size_t>(j - first_)];
      sum = sum + cotangent;
    };
    for (std::size_t k = 0; k < parts.size(); ++k) shared[k] = parts[k].template evaluate<Value>(all);
    for (const Expression& row : rows) row.pull_back(all, *of_rows++, take);
    for (std::size_t k = parts.size(); k-- > 0;) parts[k].pull_back(all, to_shared[k], take);
  }

 private:
  int first_ = 0;
};

}  // namespace nlo::codegen
