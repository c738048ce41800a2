// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluate.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "codegen/base/error.h"
#include "codegen/model/domain.h"
#include "codegen/replay/reference_monitor.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/base/parallel.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/examples.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

// Number of trajectories whose errors are summed together before the sums are joined. It is constant, so that the order
// of the additions is the same for any number of threads.
constexpr std::size_t kChunk = 4;

}  // namespace

Evaluation evaluate(const std::string& estimator, const EstimatorFactory& factory, const Dataset& clean,
                    const NoiseConfig& noise, std::uint64_t seed, int threads, const MetricsConfig& config) {
  const auto of_runs = [&]() -> RunEstimator {
    return [&clean, estimate = factory()](std::size_t run, const Eigen::MatrixXd& outputs) {
      return estimate(outputs, clean.trajectories[run].inputs, clean.trajectories[run].time_s);
    };
  };
  return evaluate_runs(estimator, of_runs, clean, noise, seed, threads, config);
}

Evaluation evaluate_runs(const std::string& estimator, const std::function<RunEstimator()>& factory,
                         const Dataset& clean, const NoiseConfig& noise, std::uint64_t seed, int threads,
                         const MetricsConfig& config) {
  const auto& runs = clean.trajectories;
  if (runs.empty()) throw Error("evaluation: the test set has no trajectory");

  Evaluation result{estimator, noise, seed, static_cast<int>(runs.size()), 0.0, clean.states, clean.outputs, {}, {}};
  for (const Trajectory& run : runs)
    if (run.samples() > 0) result.horizon_s = std::max(result.horizon_s, run.time_s[run.samples() - 1]);

  MetricsConfig metrics = config;
  if (metrics.state_scale.size() == 0 && !share_a_unit(clean.states)) metrics.state_scale = state_deviation(clean);
  const std::size_t chunks = (runs.size() + kChunk - 1) / kChunk;
  std::vector<ErrorAccumulator> sums(chunks, ErrorAccumulator(clean.states, clean.sample_period_s, metrics));
  std::vector<double> norms(runs.size());
  std::vector<CoverageSum> covered(chunks, CoverageSum(clean.states));
  ThreadPool pool(threads);
  std::vector<RunEstimator> estimators(static_cast<std::size_t>(pool.threads()));
  FirstAndWorst examples(clean);
  pool.run(static_cast<int>(chunks), [&](int task, int thread) {
    const auto chunk = static_cast<std::size_t>(task);
    RunEstimator& estimate = estimators[static_cast<std::size_t>(thread)];
    if (!estimate) estimate = factory();
    for (std::size_t i = chunk * kChunk; i < std::min(runs.size(), (chunk + 1) * kChunk); ++i) {
      Eigen::MatrixXd measured = MeasurementNoise(noise, seed, i).on(runs[i].outputs, clean.output_angles);
      Estimates estimates = estimate(i, measured);
      norms[i] = sums[chunk].add(runs[i], estimates.x_hat);
      if (estimates.sigma.size() > 0) covered[chunk].add(runs[i], estimates);
      examples.offer(i, std::move(measured), std::move(estimates.x_hat));
    }
  });

  ErrorAccumulator total(clean.states, clean.sample_period_s, metrics);
  for (const auto& sum : sums) total.merge(sum);
  result.metrics = total.metrics();
  for (std::size_t i = 0; i < norms.size(); ++i)
    if (norms[i] > result.worst) {
      result.worst = norms[i];
      result.worst_run = i;
    }
  for (std::size_t c = 1; c < chunks; ++c) covered.front().merge(covered[c]);
  result.coverage = covered.front().coverage();
  result.examples = examples.take();
  return result;
}

ObserverRun observer_run(const codegen::Model& model, bool uniform_steps, std::optional<codegen::Gate> gate) {
  auto observer = std::make_shared<codegen::ReferenceObserver<float>>(model);
  const auto watched = gate ? std::make_shared<const codegen::Model>(model) : nullptr;
  const Eigen::Index nu = model.nu();
  return [watched, observer, uniform_steps, nu, gate](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                                      const Eigen::VectorXd& time_s) {
    const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(nu, nu > 0 ? outputs.cols() : 0);
    const Eigen::MatrixXd& given = nu > 0 && inputs.size() > 0 ? inputs : none;
    if (!gate) return observer->run(outputs, given, time_s, uniform_steps);
    const Eigen::VectorXd stamps = uniform_steps ? Eigen::VectorXd() : time_s;
    return codegen::watched_run(*watched, *watched->monitor, outputs, given, stamps, *gate).run;
  };
}

bool has_uniform_steps(const Dataset& dataset, const codegen::Model& model) {
  return dataset.uniform &&
         // Tolerance for the rounding of TOML.
         std::abs(dataset.sample_period_s - model.sample_period_s) <= 1e-9 * model.sample_period_s;
}

void count_domain(const codegen::Run& run, DomainShare& share) {
  for (Eigen::Index k = 0; k < run.z.cols(); ++k) {
    const bool inside = run.in_domain[static_cast<std::size_t>(k)];
    (k == 0 ? share.runs : share.samples) += 1;
    (k == 0 ? share.first_inside : share.inside) += inside ? 1 : 0;
  }
}

EstimatorFactory observer_estimator(const codegen::Model& model, bool uniform_steps) {
  return [model, uniform_steps]() -> Estimator {
    return [model, run = observer_run(model, uniform_steps)](
               const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s) {
      return estimates_of(model, run(outputs, inputs, time_s));
    };
  };
}

EstimatorFactory readout_estimator(const codegen::Model& model, const Dataset& training, double settled_from_s) {
  auto readout = std::make_shared<LinearReadout>(model, settled_from_s);
  const ObserverRun run = observer_run(model, has_uniform_steps(training, model));
  for (const Trajectory& each : training.trajectories) readout->add(run(each.outputs, each.inputs, each.time_s), each);
  readout->fit();
  return [model, readout]() -> Estimator {
    return [readout, own = observer_run(model, false)](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                                       const Eigen::VectorXd& time_s) {
      return readout->estimate(own(outputs, inputs, time_s));
    };
  };
}

EstimatorFactory baseline_estimator(std::string_view name, const Dataset& training) {
  return [baseline = LogBaseline::fit(name, held(training), {})]() -> Estimator {
    return [baseline](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s) {
      Trajectory run;
      run.outputs = held(outputs);
      run.inputs = inputs;
      run.time_s = time_s;
      return baseline.estimate(run);
    };
  };
}

EstimatorFactory simple_estimator(std::string_view name, const codegen::Model& model, const Dataset& training,
                                  double settled_from_s) {
  return name == "ridge" ? readout_estimator(model, training, settled_from_s) : baseline_estimator(name, training);
}

Evaluation evaluate_on_plant(const codegen::Model& model, const Dataset& clean, const NoiseConfig& noise,
                             std::uint64_t seed, int threads, const MetricsConfig& config) {
  if (model.nx() != static_cast<int>(clean.states.size()) || model.ny() != static_cast<int>(clean.outputs.size()))
    throw Error("evaluation: model " + model.name + " maps " + std::to_string(model.ny()) + " outputs to " +
                std::to_string(model.nx()) + " states, the test set has " + std::to_string(clean.outputs.size()) +
                " and " + std::to_string(clean.states.size()));
  // Integers, because their sums do not depend on the order in which threads add.
  std::atomic<std::int64_t> samples = 0, inside = 0, firsts = 0, first_inside = 0;
  const bool uniform = has_uniform_steps(clean, model);
  const EstimatorFactory factory = [&]() -> Estimator {
    return [&, run = observer_run(model, uniform)](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                                   const Eigen::VectorXd& time_s) {
      const codegen::Run answer = run(outputs, inputs, time_s);
      DomainShare share;
      count_domain(answer, share);
      samples += share.samples;
      inside += share.inside;
      firsts += share.runs;
      first_inside += share.first_inside;
      return estimates_of(model, answer);
    };
  };
  Evaluation result = evaluate("observer", factory, clean, noise, seed, threads, config);
  result.domain = DomainShare{samples, inside, firsts, first_inside};
  for (EvaluatedRun& run : result.examples) run.outside = outside_of_domain(model, run, uniform);
  return result;
}

}  // namespace nlo::trainer
