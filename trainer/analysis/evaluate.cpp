// SPDX-License-Identifier: MIT
#include "trainer/analysis/evaluate.h"

#include <algorithm>
#include <memory>

#include "codegen/error.h"
#include "codegen/reference_observer.h"
#include "trainer/analysis/examples.h"
#include "trainer/analysis/measurement_noise.h"
#include "trainer/parallel.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

// Trajectories whose errors are summed together before the sums are joined. Fixed, so that the order of every addition
// is the same whatever the number of threads.
constexpr std::size_t kChunk = 4;

}  // namespace

Evaluation evaluate(const std::string& estimator, const EstimatorFactory& factory, const Dataset& clean,
                    const NoiseConfig& noise, std::uint64_t seed, int threads) {
  const auto& runs = clean.trajectories;
  if (runs.empty()) throw Error("evaluation: the test set has no trajectory");

  Evaluation result{estimator, noise, seed, static_cast<int>(runs.size()), 0.0, clean.states, clean.outputs, {}, {}};
  for (const Trajectory& run : runs)
    if (run.samples() > 0) result.horizon_s = std::max(result.horizon_s, run.time_s[run.samples() - 1]);

  const std::size_t chunks = (runs.size() + kChunk - 1) / kChunk;
  std::vector<ErrorAccumulator> sums(chunks, ErrorAccumulator(clean.states, clean.sample_period_s));
  ThreadPool pool(threads);
  std::vector<Estimator> estimators(static_cast<std::size_t>(pool.threads()));
  FirstAndWorst examples(clean);
  pool.run(static_cast<int>(chunks), [&](int task, int thread) {
    const auto chunk = static_cast<std::size_t>(task);
    Estimator& estimate = estimators[static_cast<std::size_t>(thread)];
    if (!estimate) estimate = factory();
    for (std::size_t i = chunk * kChunk; i < std::min(runs.size(), (chunk + 1) * kChunk); ++i) {
      Eigen::MatrixXd measured = MeasurementNoise(noise, seed, i).on(runs[i].outputs, clean.output_angles);
      Eigen::MatrixXd estimates = estimate(measured, runs[i].inputs, runs[i].time_s);
      sums[chunk].add(runs[i], estimates);
      examples.offer(i, std::move(measured), std::move(estimates));
    }
  });

  ErrorAccumulator total(clean.states, clean.sample_period_s);
  for (const auto& sum : sums) total.merge(sum);
  result.metrics = total.metrics();
  result.examples = examples.take();
  return result;
}

EstimatorFactory observer_estimator(const codegen::Model& model, bool uniform_steps) {
  return [model, uniform_steps]() -> Estimator {
    auto observer = std::make_shared<codegen::ReferenceObserver<float>>(model);
    const Eigen::Index nu = model.nu();
    return [observer, uniform_steps, nu](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                         const Eigen::VectorXd& time_s) {
      const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(nu, nu > 0 ? outputs.cols() : 0);
      const bool takes_inputs = nu > 0 && inputs.size() > 0;
      return observer->run(outputs, takes_inputs ? inputs : none, time_s, uniform_steps).x_hat;
    };
  };
}

EstimatorFactory constant_estimator(const Dataset& dataset) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dataset.states.size()));
  double weight = 0.0;
  for (const Trajectory& run : dataset.trajectories) {
    sum += run.states * run.weight;
    weight += run.weight.sum();
  }
  const Eigen::VectorXd mean = weight > 0.0 ? Eigen::VectorXd(sum / weight) : sum;
  return [mean]() -> Estimator {
    return [mean](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd&, const Eigen::VectorXd&) {
      return Eigen::MatrixXd(mean.replicate(1, outputs.cols()));
    };
  };
}

Evaluation evaluate_on_plant(const codegen::Model& model, const Dataset& clean, const NoiseConfig& noise,
                             std::uint64_t seed, int threads) {
  if (model.nx() != static_cast<int>(clean.states.size()) || model.ny() != static_cast<int>(clean.outputs.size()))
    throw Error("evaluation: model " + model.name + " maps " + std::to_string(model.ny()) + " outputs to " +
                std::to_string(model.nx()) + " states, the test set has " + std::to_string(clean.outputs.size()) +
                " and " + std::to_string(clean.states.size()));
  Evaluation result = evaluate("observer", observer_estimator(model, clean.uniform), clean, noise, seed, threads);
  for (EvaluatedRun& run : result.examples) run.outside = outside_of_domain(model, run, clean.uniform);
  return result;
}

}  // namespace nlo::trainer
