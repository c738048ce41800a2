// SPDX-License-Identifier: MIT
// The derivative of an expression as another expression. The covariance step and the slopes of outputs need it.
#pragma once

#include <vector>

#include "codegen/model/expression.h"

namespace nlo::codegen {

/// Nodes in postfix order, as in Expression; empty: 0.
using ExpressionNodes = std::vector<Expression::Node>;

ExpressionNodes number_nodes(double value);
ExpressionNodes reading_nodes(int reading);
/// Leaves out terms that are 0 and factors that are 1.
ExpressionNodes sum(ExpressionNodes a, const ExpressionNodes& b);
ExpressionNodes difference(ExpressionNodes a, const ExpressionNodes& b);
ExpressionNodes product(ExpressionNodes a, const ExpressionNodes& b);

/// Returns d(expression) / d(reading), or 0 where abs or sign has none. If the terms of a minimum or maximum are equal,
/// it is the mean of their slopes. The slope of a root is root(v) / (2 v + 1e-6), which also has a value at 0. That of
/// the root of a maximum is 1 / (2 max(root(v), 5e-4)), which is exact from v = 2.5e-7 on and can be bounded by
/// interval arithmetic.
ExpressionNodes derivative(const Expression& expression, int reading);

/// Returns the expression with these nodes; without nodes it is 0.
Expression expression_of(ExpressionNodes nodes);

}  // namespace nlo::codegen
