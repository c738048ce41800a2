// SPDX-License-Identifier: MIT
// The derivative of an expression as another expression. The covariance step and the slopes of outputs need it.
#pragma once

#include <vector>

#include "codegen/model/expression.h"

namespace nlo::codegen {

/// Postfix, as Expression has them; empty: 0.
using ExpressionNodes = std::vector<Expression::Node>;

ExpressionNodes number_nodes(double value);
ExpressionNodes reading_nodes(int reading);
/// Removes terms that are 0 and factors that are 1.
ExpressionNodes sum(ExpressionNodes a, const ExpressionNodes& b);
ExpressionNodes difference(ExpressionNodes a, const ExpressionNodes& b);
ExpressionNodes product(ExpressionNodes a, const ExpressionNodes& b);

/// d(expression) / d(reading). 0 where a size or a sign has none. Where the terms of a minimum or maximum are equal, it
/// is the mean of their slopes. A root's is root(v) / (2 v + 1e-6), which has a value at 0, too. A root of a maximum:
/// 1 / (2 max(root(v), 5e-4)). It is exact from v = 2.5e-7 on, and interval arithmetic finds its bound.
ExpressionNodes derivative(const Expression& expression, int reading);

/// As an expression: of nothing it is 0.
Expression expression_of(ExpressionNodes nodes);

}  // namespace nlo::codegen
