// SPDX-License-Identifier: MIT
// Expressions as one list of operations (a tape), over eight trajectories side by side, and their pullback. Each
// operation is read once for eight results. The pullback reads the values that the evaluation has stored.
#pragma once

#include <algorithm>
#include <vector>

#include "codegen/model/shared_expressions.h"
#include "trainer/structures/lane_numbers.h"

namespace nlo::trainer {

template <class Scalar>
class EquationTape {
 public:
  using L = Lanes<Scalar>;

  EquationTape() = default;
  /// The arguments of the expressions are `variables` numbers, then the constants, then the shared sub-expressions.
  EquationTape(const codegen::SharedExpressions& expressions, int variables, const std::vector<double>& constants);

  /// Returns the number of values of an evaluation: the variables, then the results of the operations.
  int size() const { return variables_ + static_cast<int>(operations_.size()); }
  /// Fills `values` after the variables.
  void evaluate(L* values) const;
  /// Returns the value of an expression after evaluate().
  L row(const L* values, int row) const {
    const Operand& of = rows_[static_cast<std::size_t>(row)];
    return of.slot < 0 ? in_lanes<L>(of.number) : values[of.slot];
  }
  /// Propagates the cotangents of the expressions to the variables.
  ///   values   result of evaluate()
  ///   to_row   to_row(i) is the cotangent of expression i
  ///   to       size() numbers; the first are filled with the cotangents of the variables
  template <class ToRow>
  void pull_back(const L* values, const ToRow& to_row, L* to) const {
    std::fill_n(to, size(), L{});
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (rows_[i].slot >= 0) to[rows_[i].slot] += to_row(static_cast<int>(i));
    pull_back(values, to);
  }

 private:
  enum class Kind {
    kSum,
    kDifference,
    kProduct,
    kQuotient,
    kMinimum,
    kMaximum,
    kSquare,
    kFunction,
    kShifted,    ///< left + number
    kReflected,  ///< number - left
    kScaled,     ///< left * number
    kInverse,    ///< number / left
    kLimited,    ///< the smaller of left and number
    kRaised,     ///< the larger of left and number
  };
  struct Operation {
    Kind kind;
    codegen::Function function;
    int left, right;
    Scalar number;
  };
  /// The value in a slot, or a number if slot is -1.
  struct Operand {
    int slot = -1;
    double number = 0.0;
  };

  Operand appended(Kind kind, int left, int right = -1, double number = 0.0, codegen::Function function = {});
  Operand combined(codegen::Expression::Kind kind, const Operand& left, const Operand& right);
  Operand applied(const codegen::Expression::Node& node, const Operand& of);
  void pull_back(const L* values, L* to) const;

  int variables_ = 0;
  std::vector<Operation> operations_;
  std::vector<Operand> rows_;
};

}  // namespace nlo::trainer
