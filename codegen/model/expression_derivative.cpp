// SPDX-License-Identifier: MIT
#include "codegen/model/expression_derivative.h"

#include <utility>

namespace nlo::codegen {
namespace {

using NodeKind = Expression::Kind;
using Nodes = ExpressionNodes;

bool is_number(const Nodes& nodes, double value) {
  return nodes.size() == 1 && nodes[0].kind == NodeKind::kNumber && nodes[0].number == value;
}

Nodes combined(Nodes a, const Nodes& b, NodeKind kind) {
  a.insert(a.end(), b.begin(), b.end());
  a.push_back({.kind = kind});
  return a;
}

Nodes quotient(Nodes a, const Nodes& b) {
  return a.empty() ? a : combined(std::move(a), b, NodeKind::kQuotient);
}

Nodes applied(Function function, Nodes nodes) {
  nodes.push_back({.kind = NodeKind::kFunction, .function = function});
  return nodes;
}

/// The slope of the root of a maximum divides by at least this root. Otherwise the slope of sqrt(max(v, 0)) would have
/// no bound.
constexpr double kLeastRoot = 5e-4;

/// Returns the slope of a function at v, where its value is f.
Nodes slope_of(Function function, const Nodes& v, const Nodes& f) {
  const Nodes one = number_nodes(1.0);
  switch (function) {
    case Function::kSine:
      return applied(Function::kCosine, v);
    case Function::kCosine:
      return product(number_nodes(-1.0), applied(Function::kSine, v));
    case Function::kTanh:
      return difference(one, product(f, f));
    case Function::kExponential:
      return f;
    case Function::kLogarithm:
      return quotient(one, v);
    case Function::kRoot:
      return v.back().kind == NodeKind::kMaximum
                 ? quotient(number_nodes(0.5), combined(f, number_nodes(kLeastRoot), NodeKind::kMaximum))
                 : quotient(f, sum(product(number_nodes(2.0), v), number_nodes(1e-6)));
    case Function::kArcTangent:
      return quotient(one, sum(one, product(v, v)));
    case Function::kMagnitude:
      return applied(Function::kSign, v);
    default:
      return {};
  }
}

struct Term {
  Nodes value, slope;
};

/// Returns the slope of a where a - b has the sign `chosen`, that of b where it has the other sign, and their mean
/// where a - b is 0.
Nodes slope_of_one(const Term& a, const Term& b, double chosen) {
  const Nodes ahead = is_number(b.value, 0.0) ? a.value : difference(a.value, b.value), half = number_nodes(0.5),
              side = product(number_nodes(0.5 * chosen), applied(Function::kSign, ahead));
  return sum(product(a.slope, sum(half, side)), product(b.slope, difference(half, side)));
}

}  // namespace

ExpressionNodes number_nodes(double value) {
  return {{.kind = NodeKind::kNumber, .number = value}};
}
ExpressionNodes reading_nodes(int reading) {
  return {{.kind = NodeKind::kReading, .reading = reading}};
}

ExpressionNodes sum(ExpressionNodes a, const ExpressionNodes& b) {
  if (a.empty()) return b;
  return b.empty() ? a : combined(std::move(a), b, NodeKind::kSum);
}
ExpressionNodes difference(ExpressionNodes a, const ExpressionNodes& b) {
  if (a.empty()) return product(number_nodes(-1.0), b);
  return b.empty() ? a : combined(std::move(a), b, NodeKind::kDifference);
}
ExpressionNodes product(ExpressionNodes a, const ExpressionNodes& b) {
  if (a.empty() || b.empty()) return {};
  if (is_number(a, 1.0)) return b;
  if (a.size() == 1 && b.size() == 1 && a[0].kind == NodeKind::kNumber && b[0].kind == NodeKind::kNumber)
    return number_nodes(a[0].number * b[0].number);
  return is_number(b, 1.0) ? a : combined(std::move(a), b, NodeKind::kProduct);
}

ExpressionNodes derivative(const Expression& expression, int reading) {
  std::vector<Term> stack;
  for (const Expression::Node& node : expression.nodes()) {
    if (node.kind == NodeKind::kNumber || node.kind == NodeKind::kReading) {
      const bool itself = node.kind == NodeKind::kReading && node.reading == reading;
      stack.push_back({{node}, itself ? number_nodes(1.0) : Nodes()});
      continue;
    }
    if (node.kind == NodeKind::kFunction) {
      Term& of = stack.back();
      Nodes value = applied(node.function, of.value);
      of.slope = product(slope_of(node.function, of.value, value), of.slope);
      of.value = std::move(value);
      continue;
    }
    if (node.kind == NodeKind::kSquare) {
      Term& of = stack.back();
      of.slope = product(number_nodes(2.0), product(of.value, of.slope));
      of.value.push_back(node);
      continue;
    }
    const Term right = std::move(stack.back());
    stack.pop_back();
    Term& left = stack.back();
    Nodes value = combined(left.value, right.value, node.kind);
    if (node.kind == NodeKind::kSum) left.slope = sum(left.slope, right.slope);
    if (node.kind == NodeKind::kDifference) left.slope = difference(left.slope, right.slope);
    if (node.kind == NodeKind::kProduct)
      left.slope = sum(product(left.slope, right.value), product(left.value, right.slope));
    if (node.kind == NodeKind::kQuotient)
      left.slope = difference(quotient(left.slope, right.value), quotient(product(value, right.slope), right.value));
    if (node.kind == NodeKind::kMinimum) left.slope = slope_of_one(left, right, -1.0);
    if (node.kind == NodeKind::kMaximum) left.slope = slope_of_one(left, right, 1.0);
    left.value = std::move(value);
  }
  return stack.back().slope;
}

Expression expression_of(ExpressionNodes nodes) {
  return Expression(nodes.empty() ? number_nodes(0.0) : std::move(nodes));
}

}  // namespace nlo::codegen
