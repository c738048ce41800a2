// SPDX-License-Identifier: MIT
// The test that everything here is judged by: an estimator sees the noisy outputs of every trajectory of a set, once,
// and its estimates are compared with the truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/base/noise.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/evaluation/closed_loop.h"
#include "trainer/judge/evaluation/coverage.h"
#include "trainer/judge/evaluation/linear_readout.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {

struct NamedModel {
  std::string name;  ///< in tables and in JSON
  codegen::Model model;
};

/// Called with the finished share of all work, and the current work. One call at a time, from any thread.
using StudyProgress = std::function<void(double share, const std::string& what)>;

/// Estimates over one run from reset, causal:
///   outputs  n_y x N  as measured
///   inputs   n_u x N  excitation of the plant, without noise; 0 x 0 without inputs
///   time_s   N
using Estimator = std::function<Estimates(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                          const Eigen::VectorXd& time_s)>;

/// An estimator that is given the number of the run in the test set.
using RunEstimator = std::function<Estimates(std::size_t run, const Eigen::MatrixXd& outputs)>;

/// Makes an estimator; each thread asks for its own, so that it may keep work memory.
using EstimatorFactory = std::function<Estimator()>;

/// One run of the test, kept for plots.
struct EvaluatedRun {
  Trajectory truth;              ///< clean outputs and states
  Eigen::MatrixXd measured;      ///< n_y x N, readings of the estimator
  Eigen::MatrixXd estimate;      ///< n_x x N
  std::string why = {};          ///< "first", "best", "worst": why it is among the examples; may be empty
  Eigen::VectorXd outside = {};  ///< N: 1 where z is outside of the training domain; size 0: not known
  /// Estimates of all states of the model, if only some have a truth; 0 x 0: `estimate` has all.
  Eigen::MatrixXd all_estimates = {};
};

/// How often z was where training has been. The first sample of each run is counted apart: there z is the observer's
/// start.
struct DomainShare {
  std::int64_t samples = 0, inside = 0;  ///< after the first of each run
  std::int64_t runs = 0, first_inside = 0;

  double share() const { return samples > 0 ? static_cast<double>(inside) / static_cast<double>(samples) : 1.0; }
};

struct Evaluation {
  /// "observer", "ekf", "ukf", "ekf_true", "constant", "ridge"; in its own loop: "observer_in_loop" ...
  std::string estimator;
  NoiseConfig noise;
  std::uint64_t seed = 0;
  int trajectories = 0;
  double horizon_s = 0.0;
  std::vector<Channel> states, outputs;
  ErrorMetrics metrics;
  std::vector<EvaluatedRun> examples;                                ///< the first trajectory, then the worst
  std::vector<std::pair<std::string, std::string>> excitation = {};  ///< name and u(t) of each input
  std::optional<DomainShare> domain = {};                            ///< share of the observer's domain
  std::string label = {};                   ///< the estimator for people, where its name does not say all
  std::optional<ClosedLoopCost> loop = {};  ///< cost of an estimator in its own loop
  std::optional<Coverage> coverage = {};    ///< intervals of an estimator that reports its error
  double worst = 0.0;                       ///< the largest norm of a run
  std::size_t worst_run = 0;                ///< number of that run in the test set
  std::string changed = {};                 ///< changes of the plant since the training: KEY=VALUE, ...
};

/// Strict noise (measurement_noise.h) on `clean`, then the estimator; coverage where it gives intervals. `threads` 0:
/// all cores. The result has the same bytes for any number of threads. Norms over states whose units differ are of
/// states over their deviation in `clean`, unless `config` has a state_scale.
Evaluation evaluate_runs(const std::string& estimator, const std::function<RunEstimator()>& factory,
                         const Dataset& clean, const NoiseConfig& noise, std::uint64_t seed, int threads,
                         const MetricsConfig& config = {});
Evaluation evaluate(const std::string& estimator, const EstimatorFactory& factory, const Dataset& clean,
                    const NoiseConfig& noise, std::uint64_t seed, int threads, const MetricsConfig& config = {});

/// A model's whole answer over one run, in float, as it flies; arguments as those of an Estimator. A model without
/// phi(z) u (25) has no use for the inputs. Not for two threads at once.
///   gate  if given, the model's monitor (which it must have) watches each step, and the run of a model with an error
///         head also has widened_sigma; kUsed: outputs pass the monitor's gate
using ObserverRun = std::function<codegen::Run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                               const Eigen::VectorXd& time_s)>;
ObserverRun observer_run(const codegen::Model& model, bool uniform_steps, std::optional<codegen::Gate> gate = {});

/// Every step of the data is the model's own sample period: time stamps need not be asked.
bool has_uniform_steps(const Dataset& dataset, const codegen::Model& model);

/// Adds a run's samples inside and outside of the model's domain.
void count_domain(const codegen::Run& run, DomainShare& share);

/// Estimates by observer_run().
EstimatorFactory observer_estimator(const codegen::Model& model, bool uniform_steps);

/// The linear readout of the model's features, fitted on `training`, whose outputs have the noise.
///   settled_from_s  see LinearReadout
EstimatorFactory readout_estimator(const codegen::Model& model, const Dataset& training, double settled_from_s);

/// An estimator without a plant or a model, fitted likewise: the LogBaseline "constant" (the mean state) or
/// "static_ridge". Samples that do not arrive are held.
EstimatorFactory baseline_estimator(std::string_view name, const Dataset& training);

/// One of simple_names(), fitted likewise: "ridge" is the readout of the model, the others are baselines.
EstimatorFactory simple_estimator(std::string_view name, const codegen::Model& model, const Dataset& training,
                                  double settled_from_s);

/// evaluate() of a model, with its domain; its examples also say where z leaves it.
Evaluation evaluate_on_plant(const codegen::Model& model, const Dataset& clean, const NoiseConfig& noise,
                             std::uint64_t seed, int threads, const MetricsConfig& config = {});

}  // namespace nlo::trainer
