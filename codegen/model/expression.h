// SPDX-License-Identifier: MIT
// Expressions of readings. Computed outputs may have sums, products and integer powers. Known equations may also
// divide, call functions, and take the minimum or maximum of several values. Exports and training evaluate them in the
// order in which they are written.
//   1.5 * yaw_rate * wheel_speed - slope^2               -(w2 * sin(angle) + b * rate) / (j + cos(angle)^2)
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model/expression_values.h"

namespace nlo::codegen {

class Expression {
 public:
  /// Allowed operations. Computed outputs may only divide by numbers, because a measured value may be 0.
  enum class Language { kPolynomial, kFunctions };

  enum class Kind { kNumber, kReading, kSum, kDifference, kProduct, kQuotient, kMinimum, kMaximum, kSquare, kFunction };
  /// Nodes in the order of evaluation: operands come before their operation.
  struct Node {
    Kind kind;
    double number = 0.0;
    int reading = 0;
    Function function = {};
  };

  /// `names` are the readings in their order. An empty name stands for a reading that the expression must not read.
  /// Throws Error with the place in `text` and the expected symbols.
  Expression(std::string_view text, const std::vector<std::string>& names, Language language = Language::kPolynomial);
  explicit Expression(std::vector<Node> nodes);

  /// Returns the value of the expression; reading(j) is the value of reading j.
  template <class Value, class Reading>
  Value evaluate(const Reading& reading) const {
    std::array<Value, kMostPending> stack;
    std::size_t size = 0;
    for (const Node& node : nodes_) {
      switch (node.kind) {
        case Kind::kNumber:
          stack[size++] = Value(node.number);
          continue;
        case Kind::kReading:
          stack[size++] = reading(node.reading);
          continue;
        case Kind::kFunction:
          stack[size - 1] = value_of(node.function, stack[size - 1]);
          continue;
        case Kind::kSquare:
          stack[size - 1] = square(stack[size - 1]);
          continue;
        default:
          break;
      }
      const Value right = stack[--size];
      Value& left = stack[size - 1];
      if (node.kind == Kind::kSum) left = left + right;
      if (node.kind == Kind::kDifference) left = left - right;
      if (node.kind == Kind::kProduct) left = left * right;
      if (node.kind == Kind::kQuotient) left = left / right;
      if (node.kind == Kind::kMinimum) left = minimum_of(left, right);
      if (node.kind == Kind::kMaximum) left = maximum_of(left, right);
    }
    return stack[0];
  }

  /// Returns the text in C and C++. Functions write a reading, a number, and a product that is part of a sum or the
  /// argument of a function. `is_part`: the expression itself is part of a sum.
  std::string text(const std::function<std::string(int)>& reading, const std::function<std::string(double)>& number,
                   const std::function<std::string(const std::string&)>& part_of_sum, bool is_part = false) const;

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<int>& reads() const { return reads_; }  ///< indices of the readings that it reads, ascending
  int operations() const;  ///< number of multiplications, divisions, additions, minima and maxima
  int functions() const;   ///< number of function calls

  /// Returns the parity of the expression from the parities of the readings.
  Parity parity(const std::vector<Parity>& readings) const;

 private:
  friend class ExpressionParser;
  static constexpr std::size_t kMostNodes = 64, kMostNodesOfEquation = 512;
  static constexpr std::size_t kMostPending = 64;  ///< operands of operations that wait for others

  void finish();

  std::vector<Node> nodes_;
  std::vector<int> reads_;
};

}  // namespace nlo::codegen
