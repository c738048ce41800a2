// SPDX-License-Identifier: MIT
// Outputs that are computed of other readings: sums and products of them, whole powers, numbers. Flight computes them
// as training did, in the order in which they are written.
//   1.5 * yaw_rate * wheel_speed - slope^2
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"

namespace nlo::codegen {

/// All values that a quantity may have.
struct Interval {
  double low = 0.0, high = 0.0;

  Interval(double value = 0.0) : low(value), high(value) {}  // NOLINT: a number is an interval
  Interval(double from, double to) : low(from), high(to) {}
};
Interval operator+(Interval a, Interval b);
Interval operator-(Interval a, Interval b);
Interval operator*(Interval a, Interval b);

/// What becomes of a quantity when all that is odd changes its sign.
enum class Parity { kOdd, kEven, kNeither };

class Expression {
 public:
  /// `names` are those of the readings that it may read, in their order; "" in the place of one that it may not. Throws
  /// Error, with the place in `text` and what is allowed there.
  Expression(std::string_view text, const std::vector<std::string>& names);

  /// Its value where reading j is reading(j).
  template <class Value, class Reading>
  Value evaluate(const Reading& reading) const {
    std::array<Value, kMostNodes> stack;
    std::size_t size = 0;
    for (const Node& node : nodes_) {
      if (node.kind == Kind::kNumber) {
        stack[size++] = Value(node.number);
      } else if (node.kind == Kind::kReading) {
        stack[size++] = reading(node.reading);
      } else {
        const Value right = stack[--size];
        Value& left = stack[size - 1];
        left = node.kind == Kind::kSum ? left + right : node.kind == Kind::kDifference ? left - right : left * right;
      }
    }
    return stack[0];
  }

  /// As C and C++ write it, with texts for a reading, for a number, and for a product that is a part of a sum.
  std::string text(const std::function<std::string(int)>& reading, const std::function<std::string(double)>& number,
                   const std::function<std::string(const std::string&)>& part_of_sum) const;

  const std::vector<int>& reads() const { return reads_; }  ///< which readings, rising
  int operations() const;                                   ///< multiplications and additions

  /// From that of the readings.
  Parity parity(const std::vector<Parity>& readings) const;

 private:
  friend class ExpressionParser;
  static constexpr std::size_t kMostNodes = 64;
  enum class Kind { kNumber, kReading, kSum, kDifference, kProduct };
  /// In the order of evaluation: what an operation combines stands before it.
  struct Node {
    Kind kind;
    double number = 0.0;
    int reading = 0;
  };

  std::vector<Node> nodes_;
  std::vector<int> reads_;
};

}  // namespace nlo::codegen
