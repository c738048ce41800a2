// SPDX-License-Identifier: MIT
// Expressions over readings: computed outputs, sums, products and whole powers; and known equations, which may also
// divide and name functions. Flight computes them as training did, in the order in which they are written.
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
  /// What may be written: computed outputs divide by numbers alone, as what is measured may be 0.
  enum class Language { kPolynomial, kFunctions };

  enum class Kind { kNumber, kReading, kSum, kDifference, kProduct, kQuotient, kSquare, kFunction };
  /// In the order of evaluation: what an operation combines stands before it.
  struct Node {
    Kind kind;
    double number = 0.0;
    int reading = 0;
    Function function = {};
  };

  /// `names` are those of the readings that it may read, in their order; "" in the place of one that it may not. Throws
  /// Error, with the place in `text` and what is allowed there.
  Expression(std::string_view text, const std::vector<std::string>& names, Language language = Language::kPolynomial);
  explicit Expression(std::vector<Node> nodes);

  /// Its value where reading j is reading(j).
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
    }
    return stack[0];
  }

  /// As C and C++ write it, with texts for a reading, for a number, and for a product that is a part of a sum, or that
  /// a function takes. `is_part`: of a sum that is elsewhere.
  std::string text(const std::function<std::string(int)>& reading, const std::function<std::string(double)>& number,
                   const std::function<std::string(const std::string&)>& part_of_sum, bool is_part = false) const;

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<int>& reads() const { return reads_; }  ///< which readings, rising
  int operations() const;                                   ///< multiplications, divisions and additions
  int functions() const;                                    ///< evaluations of one

  /// From that of the readings.
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
