// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/error_samples.h"

#include "codegen/model/domain.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/rollout/sampled_truth.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  if (a.size() == 0) return b;
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

}  // namespace

Eigen::VectorXd ErrorSamples::known_weights() const {
  Eigen::VectorXd inside = weights;
  for (Index k = 0; k < size(); ++k)
    if (!known[static_cast<std::size_t>(k)]) inside(k) = 0.0;
  return inside.sum() > 0.0 ? inside : weights;
}

void ErrorSamples::append(const ErrorSamples& more) {
  hidden = joined(hidden, more.hidden);
  errors = joined(errors, more.errors);
  weights = joined(weights.transpose(), more.weights.transpose()).transpose();
  known.insert(known.end(), more.known.begin(), more.known.end());
}

ErrorSamples error_samples(const codegen::Model& model, const Rollout& rollout, Index count) {
  const SampledTruth sampled = sample_truth(model, rollout, count);
  const codegen::ReferenceObserver<float> observer(model);
  ErrorSamples samples;
  samples.weights = sampled.weights;
  samples.hidden = observer.last_hidden(sampled.z, sampled.y);
  samples.errors = errors_of(observer.estimates(sampled.z, sampled.y), sampled.x, model.states);
  const codegen::LatentDomain domain(model);
  for (Index k = 0; k < samples.size(); ++k)
    samples.known.push_back(domain.contains(sampled.z.col(k), sampled.y.col(k)));
  return samples;
}

}  // namespace nlo::trainer
