// SPDX-License-Identifier: MIT
#include "trainer/structures/equation_tape.h"

#include <algorithm>
#include <cstddef>

namespace nlo::trainer {

using codegen::Expression;

template <class Scalar>
EquationTape<Scalar>::EquationTape(const codegen::SharedExpressions& expressions, int variables,
                                   const std::vector<double>& constants)
    : variables_(variables) {
  std::vector<Operand> readings;
  for (int i = 0; i < variables; ++i) readings.push_back({.slot = i});
  for (const double number : constants) readings.push_back({.number = number});
  const auto written = [&](const Expression& expression) {
    std::vector<Operand> stack;
    const auto pop = [&stack] {
      const Operand top = stack.back();
      stack.pop_back();
      return top;
    };
    for (const Expression::Node& node : expression.nodes()) {
      if (node.kind == Expression::Kind::kNumber) {
        stack.push_back({.number = node.number});
      } else if (node.kind == Expression::Kind::kReading) {
        stack.push_back(readings[static_cast<std::size_t>(node.reading)]);
      } else if (node.kind == Expression::Kind::kFunction || node.kind == Expression::Kind::kSquare) {
        stack.push_back(applied(node, pop()));
      } else {
        const Operand right = pop(), left = pop();
        stack.push_back(combined(node.kind, left, right));
      }
    }
    return stack.back();
  };
  for (const Expression& part : expressions.parts) readings.push_back(written(part));
  for (const Expression& row : expressions.rows) rows_.push_back(written(row));
}

template <class Scalar>
auto EquationTape<Scalar>::appended(Kind kind, int left, int right, double number, codegen::Function function)
    -> Operand {
  operations_.push_back({kind, function, left, right, static_cast<Scalar>(number)});
  return {.slot = size() - 1};
}

template <class Scalar>
auto EquationTape<Scalar>::applied(const Expression::Node& node, const Operand& of) -> Operand {
  const bool square = node.kind == Expression::Kind::kSquare;
  if (of.slot >= 0) return appended(square ? Kind::kSquare : Kind::kFunction, of.slot, -1, 0.0, node.function);
  return {.number = square ? of.number * of.number : codegen::value_of(node.function, of.number)};
}

/// Operations on constants are computed once here, not at every evaluation.
template <class Scalar>
auto EquationTape<Scalar>::combined(Expression::Kind kind, const Operand& left, const Operand& right) -> Operand {
  const bool by_left = left.slot < 0, by_right = right.slot < 0, both = by_left && by_right;
  const double a = left.number, b = right.number;
  const int of = by_left ? right.slot : left.slot;
  switch (kind) {
    case Expression::Kind::kSum:
      if (both) return {.number = a + b};
      return by_left || by_right ? appended(Kind::kShifted, of, -1, a + b)
                                 : appended(Kind::kSum, left.slot, right.slot);
    case Expression::Kind::kDifference:
      if (both) return {.number = a - b};
      if (by_left) return appended(Kind::kReflected, of, -1, a);
      return by_right ? appended(Kind::kShifted, of, -1, -b) : appended(Kind::kDifference, left.slot, right.slot);
    case Expression::Kind::kProduct:
      if (both) return {.number = a * b};
      if (by_left || by_right) return appended(Kind::kScaled, of, -1, by_left ? a : b);
      return appended(Kind::kProduct, left.slot, right.slot);
    case Expression::Kind::kMinimum:
      if (both) return {.number = codegen::minimum_of(a, b)};
      return by_left || by_right ? appended(Kind::kLimited, of, -1, by_left ? a : b)
                                 : appended(Kind::kMinimum, left.slot, right.slot);
    case Expression::Kind::kMaximum:
      if (both) return {.number = codegen::maximum_of(a, b)};
      return by_left || by_right ? appended(Kind::kRaised, of, -1, by_left ? a : b)
                                 : appended(Kind::kMaximum, left.slot, right.slot);
    default:
      if (both) return {.number = a / b};
      if (by_left) return appended(Kind::kInverse, of, -1, a);
      return by_right ? appended(Kind::kScaled, of, -1, 1.0 / b) : appended(Kind::kQuotient, left.slot, right.slot);
  }
}

template <class Scalar>
void EquationTape<Scalar>::evaluate(L* values) const {
  L* value = values + variables_;
  for (const Operation& operation : operations_) {
    const L left = values[operation.left];
    const auto right = [&] { return values[operation.right]; };
    switch (operation.kind) {
      case Kind::kSum:
        *value = left + right();
        break;
      case Kind::kDifference:
        *value = left - right();
        break;
      case Kind::kProduct:
        *value = left * right();
        break;
      case Kind::kQuotient:
        *value = left / right();
        break;
      case Kind::kSquare:
        *value = left * left;
        break;
      case Kind::kFunction:
        *value = value_of_lanes(operation.function, left);
        break;
      case Kind::kShifted:
        *value = left + operation.number;
        break;
      case Kind::kReflected:
        *value = operation.number - left;
        break;
      case Kind::kScaled:
        *value = left * operation.number;
        break;
      case Kind::kInverse:
        *value = operation.number / left;
        break;
      case Kind::kMinimum:
        *value = left > right() ? right() : left;
        break;
      case Kind::kMaximum:
        *value = left < right() ? right() : left;
        break;
      case Kind::kLimited: {
        const L number = simd::broadcast<L>(operation.number);
        *value = left > number ? number : left;
        break;
      }
      case Kind::kRaised: {
        const L number = simd::broadcast<L>(operation.number);
        *value = left < number ? number : left;
        break;
      }
    }
    ++value;
  }
}

/// Returns the share of the left operand in the slope of a maximum or minimum: 1, 0, or 1/2 if both operands are equal.
template <class L>
static L share_of(bool maximum, L left, L right) {
  const L ahead = maximum ? left - right : right - left;
  return ahead > L{} ? in_lanes<L>(1.0) : ahead < L{} ? L{} : in_lanes<L>(0.5);
}

template <class Scalar>
void EquationTape<Scalar>::pull_back(const L* values, L* to) const {
  for (std::size_t i = operations_.size(); i-- > 0;) {
    const Operation& operation = operations_[i];
    const std::size_t slot = static_cast<std::size_t>(variables_) + i;
    const L own = to[slot], left = values[operation.left];
    L& to_left = to[operation.left];
    switch (operation.kind) {
      case Kind::kSum:
        to_left += own;
        to[operation.right] += own;
        break;
      case Kind::kDifference:
        to_left += own;
        to[operation.right] -= own;
        break;
      case Kind::kProduct:
        to_left += own * values[operation.right];
        to[operation.right] += own * left;
        break;
      case Kind::kQuotient: {
        const L share = own / values[operation.right];
        to_left += share;
        to[operation.right] -= share * values[slot];
        break;
      }
      case Kind::kSquare:
        to_left += (own + own) * left;
        break;
      case Kind::kFunction:
        to_left += own * slope_of_lanes(operation.function, left, values[slot]);
        break;
      case Kind::kShifted:
        to_left += own;
        break;
      case Kind::kReflected:
        to_left -= own;
        break;
      case Kind::kScaled:
        to_left += own * operation.number;
        break;
      case Kind::kInverse:
        to_left -= own * values[slot] / left;
        break;
      case Kind::kMinimum:
      case Kind::kMaximum: {
        const L right = values[operation.right], share = share_of(operation.kind == Kind::kMaximum, left, right);
        to_left += own * share;
        to[operation.right] += own - own * share;
        break;
      }
      case Kind::kLimited:
      case Kind::kRaised:
        to_left += own * share_of(operation.kind == Kind::kRaised, left, simd::broadcast<L>(operation.number));
        break;
    }
  }
}

template class EquationTape<float>;
template class EquationTape<double>;

}  // namespace nlo::trainer
