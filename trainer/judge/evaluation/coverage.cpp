// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/coverage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {
using Eigen::Index;
using Eigen::VectorXd;

Estimates normal_intervals(Eigen::MatrixXd x_hat, const Eigen::MatrixXd& deviations) {
  constexpr double kNormal68 = 0.994457883209753, kNormal95 = 1.959963984540054;
  return {std::move(x_hat), kNormal68 * deviations, kNormal95 * deviations};
}

CoverageSum::CoverageSum(const std::vector<Channel>& states) {
  for (const Channel& state : states) wraps_.push_back(state.wrap);
  within_68_ = within_95_ = sigma_ = known_ = VectorXd::Zero(static_cast<Index>(states.size()));
}

void CoverageSum::add(const Trajectory& truth, const Estimates& estimates) {
  for (Index k = 0; k < truth.samples(); ++k) {
    const double weight = truth.weight.size() == 0 ? 1.0 : truth.weight[k];
    if (weight <= 0.0 || k < truth.first_estimate) continue;
    weight_ += weight;
    for (Index i = 0; i < within_68_.size(); ++i) {
      if (estimates.sigma(i, k) >= static_cast<double>(kUnknownSigma)) continue;
      known_(i) += weight;
      const double error =
          std::abs(wrapped_difference(truth.states(i, k), estimates.x_hat(i, k), wraps_[static_cast<std::size_t>(i)]));
      within_68_(i) += error <= estimates.sigma(i, k) ? weight : 0.0;
      within_95_(i) += error <= estimates.bound_95(i, k) ? weight : 0.0;
      sigma_(i) += weight * estimates.sigma(i, k);
    }
  }
}

void CoverageSum::merge(const CoverageSum& other) {
  within_68_ += other.within_68_;
  within_95_ += other.within_95_;
  sigma_ += other.sigma_;
  known_ += other.known_;
  weight_ += other.weight_;
}

std::optional<Coverage> CoverageSum::coverage() const {
  if (weight_ <= 0.0) return std::nullopt;
  return Coverage{within_68_.cwiseQuotient(known_), within_95_.cwiseQuotient(known_), sigma_.cwiseQuotient(known_),
                  (1.0 - known_.array() / weight_).matrix()};
}

namespace {

Estimates with_sigma(const codegen::Model& model, const codegen::Run& run, const Eigen::MatrixXd& sigma) {
  const VectorXd ratio = model.error->factor_95.cwiseQuotient(model.error->factor_68);
  return {run.x_hat, sigma, ratio.asDiagonal() * sigma};
}

}  // namespace

Estimates estimates_of(const codegen::Model& model, const codegen::Run& run) {
  if (!model.error) return run.x_hat;
  return with_sigma(model, run, run.sigma);
}

Estimates widened_estimates_of(const codegen::Model& model, const codegen::Run& run) {
  return with_sigma(model, run, run.widened_sigma);
}

std::optional<Coverage> mean_coverage(const std::vector<std::optional<Coverage>>& all) {
  if (all.empty() || !std::all_of(all.begin(), all.end(), [](const auto& one) { return one.has_value(); }))
    return std::nullopt;
  Coverage mean = *all.front();
  for (std::size_t i = 1; i < all.size(); ++i) {
    mean.share_68 += all[i]->share_68;
    mean.share_95 += all[i]->share_95;
    mean.sigma += all[i]->sigma;
    mean.unknown += all[i]->unknown;
  }
  const auto count = static_cast<double>(all.size());
  return Coverage{mean.share_68 / count, mean.share_95 / count, mean.sigma / count, mean.unknown / count};
}

}  // namespace nlo::trainer
