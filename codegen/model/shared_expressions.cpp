// SPDX-License-Identifier: MIT
#include "codegen/model/shared_expressions.h"

#include <functional>
#include <map>
#include <tuple>
#include <utility>

namespace nlo::codegen {

SharedExpressions::SharedExpressions(const std::vector<Expression>& all, int first) : first_(first) {
  using Node = Expression::Node;
  using Kind = Expression::Kind;
  struct Operation {
    Node node;
    int left, right;  // -1: none
    int users = 0;
    int part = -1;
  };
  std::vector<Operation> operations;
  std::map<std::tuple<Kind, double, int, Function, int, int>, int> known;
  std::vector<int> tops;
  for (const Expression& expression : all) {
    std::vector<int> stack;
    const auto pop = [&stack] {
      const int top = stack.back();
      stack.pop_back();
      return top;
    };
    for (Node node : expression.nodes()) {
      const bool leaf = node.kind == Kind::kNumber || node.kind == Kind::kReading;
      int right = leaf || node.kind == Kind::kFunction ? -1 : pop();
      const int left = leaf ? -1 : pop();
      if (node.kind == Kind::kProduct && left == right) node.kind = Kind::kSquare;
      const bool square = node.kind == Kind::kSquare;
      if (square) right = -1;
      const auto [found, is_new] = known.try_emplace({node.kind, node.number, node.reading, node.function, left, right},
                                                     static_cast<int>(operations.size()));
      if (is_new) {
        operations.push_back({node, left, right});
        if (left >= 0) operations[static_cast<std::size_t>(left)].users += square ? 2 : 1;
        if (right >= 0) operations[static_cast<std::size_t>(right)].users += 1;
      }
      stack.push_back(found->second);
    }
    tops.push_back(stack.back());
    ++operations[static_cast<std::size_t>(stack.back())].users;
  }
  const auto written = [&](int top) {
    std::vector<Node> nodes;
    const std::function<void(int)> write = [&](int at) {
      const Operation& operation = operations[static_cast<std::size_t>(at)];
      if (operation.part >= 0) return nodes.push_back({.kind = Kind::kReading, .reading = first + operation.part});
      if (operation.left >= 0) write(operation.left);
      if (operation.right >= 0) write(operation.right);
      nodes.push_back(operation.node);
    };
    write(top);
    return Expression(std::move(nodes));
  };
  for (std::size_t i = 0; i < operations.size() && parts.size() < kMostParts; ++i) {
    if (operations[i].users < 2 || operations[i].left < 0) continue;
    parts.push_back(written(static_cast<int>(i)));
    operations[i].part = static_cast<int>(parts.size()) - 1;
  }
  for (const int top : tops) rows.push_back(written(top));
}

}  // namespace nlo::codegen
