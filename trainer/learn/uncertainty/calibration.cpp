// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/calibration.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace nlo::trainer {

double weighted_quantile(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double p) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values(a) < values(b); });
  // Sums of many weights have rounding errors, so the last value must be the largest quantile for any sum.
  constexpr double kRounding = 1e-12;
  const double wanted = p * weights.sum() * (1.0 - kRounding);
  double below = 0.0;
  for (const Eigen::Index k : order) {
    below += weights(k);
    if (below >= wanted) return values(k);
  }
  return values(order.back());
}

Eigen::MatrixXd deviations_everywhere(const codegen::ErrorHead& head, const ErrorSamples& samples) {
  return codegen::deviations(head, samples.hidden, std::vector<bool>(samples.known.size(), true));
}

ErrorScores error_scores(const codegen::ErrorHead& head, const ErrorSamples& samples) {
  return {samples.errors.cwiseAbs().cwiseQuotient(deviations_everywhere(head, samples)), samples.known_weights()};
}

void calibrate(codegen::ErrorHead& head, const std::vector<ErrorScores>& sets) {
  constexpr double kLeast = 1e-3, kMost = 1e3;  // limits in a model file
  const auto count = static_cast<Eigen::Index>(sets.size());
  for (Eigen::Index i = 0; i < head.factor_68.size(); ++i) {
    const auto factor = [&](double p) {
      Eigen::VectorXd of_set(count);
      for (Eigen::Index s = 0; s < count; ++s) {
        const ErrorScores& set = sets[static_cast<std::size_t>(s)];
        of_set(s) = weighted_quantile(set.ratios.row(i), set.weights, p);
      }
      return std::clamp(weighted_quantile(of_set, Eigen::VectorXd::Ones(count), p), kLeast, kMost);
    };
    head.factor_68(i) = factor(0.68);
    head.factor_95(i) = factor(0.95);
  }
}

}  // namespace nlo::trainer
