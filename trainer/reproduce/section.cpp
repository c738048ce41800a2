// SPDX-License-Identifier: MIT
#include "trainer/reproduce/section.h"

#include <cmath>
#include <limits>

namespace nlo::trainer::reproduction {

Spread spread(const std::vector<double>& values) {
  if (values.empty()) return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  const double mean = sum / n;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / n)};
}

std::optional<double> deviation_from_paper(const Cell& cell) {
  if (!cell.paper || cell.paper_like.empty()) return std::nullopt;
  return spread(cell.paper_like).mean / *cell.paper - 1.0;
}

bool is_outside(const Cell& cell) {
  const auto deviation = deviation_from_paper(cell);
  return deviation && std::abs(*deviation) > kTolerance;
}

Ordering at_most(std::string claim, const Cell& cell, double limit) {
  return per_seed(std::move(claim), cell.strict.size(), [&](std::size_t seed) { return cell.strict[seed] <= limit; });
}

Ordering better(std::string claim, const Cell& cell, const Cell& than) {
  return per_seed(std::move(claim), cell.strict.size(),
                  [&](std::size_t seed) { return cell.strict[seed] < than.strict[seed]; });
}

}  // namespace nlo::trainer::reproduction
