// SPDX-License-Identifier: MIT
#include "trainer/evaluation/coverage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kChunk = 4;  // runs whose sums are joined first, whatever the number of threads

}  // namespace

IntervalEstimates normal_intervals(Eigen::MatrixXd x_hat, const Eigen::MatrixXd& deviations) {
  constexpr double kNormal68 = 0.994457883209753, kNormal95 = 1.959963984540054;
  return {std::move(x_hat), kNormal68 * deviations, kNormal95 * deviations};
}

CoverageSum::CoverageSum(const std::vector<Channel>& states) {
  for (const Channel& state : states) wraps_.push_back(state.wrap);
  within_68_ = within_95_ = sigma_ = VectorXd::Zero(static_cast<Index>(states.size()));
}

void CoverageSum::add(const Trajectory& truth, const IntervalEstimates& estimates) {
  for (Index k = 0; k < truth.samples(); ++k) {
    const double weight = truth.weight.size() == 0 ? 1.0 : truth.weight[k];
    if (weight <= 0.0 || k < truth.first_estimate) continue;
    weight_ += weight;
    for (Index i = 0; i < within_68_.size(); ++i) {
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
  weight_ += other.weight_;
}

std::optional<Coverage> CoverageSum::coverage() const {
  if (weight_ <= 0.0) return std::nullopt;
  return Coverage{within_68_ / weight_, within_95_ / weight_, sigma_ / weight_};
}

std::optional<Coverage> coverage_on(const IntervalEstimatorFactory& factory, const Dataset& clean,
                                    const NoiseConfig& noise, std::uint64_t seed, int threads) {
  const auto& runs = clean.trajectories;
  const std::size_t chunks = (runs.size() + kChunk - 1) / kChunk;
  std::vector<CoverageSum> sums(chunks, CoverageSum(clean.states));
  ThreadPool pool(threads);
  std::vector<IntervalEstimator> estimators(static_cast<std::size_t>(pool.threads()));
  pool.run(static_cast<int>(chunks), [&](int task, int thread) {
    const auto chunk = static_cast<std::size_t>(task);
    IntervalEstimator& estimate = estimators[static_cast<std::size_t>(thread)];
    if (!estimate) estimate = factory();
    for (std::size_t i = chunk * kChunk; i < std::min(runs.size(), (chunk + 1) * kChunk); ++i)
      sums[chunk].add(runs[i], estimate(MeasurementNoise(noise, seed, i).on(runs[i].outputs, clean.output_angles),
                                        runs[i].inputs, runs[i].time_s));
  });
  CoverageSum total(clean.states);
  for (const CoverageSum& sum : sums) total.merge(sum);
  return total.coverage();
}

IntervalEstimates intervals_of(const codegen::Model& model, const codegen::Run& run) {
  const VectorXd ratio = model.error->factor_95.cwiseQuotient(model.error->factor_68);
  return {run.x_hat, run.sigma, ratio.asDiagonal() * run.sigma};
}

IntervalEstimatorFactory observer_intervals(const codegen::Model& model, bool uniform_steps) {
  return [&model, uniform_steps]() -> IntervalEstimator {
    return [&model, run = observer_run(model, uniform_steps)](const Eigen::MatrixXd& outputs,
                                                              const Eigen::MatrixXd& inputs, const VectorXd& time_s) {
      return intervals_of(model, run(outputs, inputs, time_s));
    };
  };
}

std::optional<Coverage> mean_coverage(const std::vector<std::optional<Coverage>>& all) {
  if (all.empty() || !std::all_of(all.begin(), all.end(), [](const auto& one) { return one.has_value(); }))
    return std::nullopt;
  Coverage mean = *all.front();
  for (std::size_t i = 1; i < all.size(); ++i) {
    mean.share_68 += all[i]->share_68;
    mean.share_95 += all[i]->share_95;
    mean.sigma += all[i]->sigma;
  }
  const auto count = static_cast<double>(all.size());
  return Coverage{mean.share_68 / count, mean.share_95 / count, mean.sigma / count};
}

}  // namespace nlo::trainer
