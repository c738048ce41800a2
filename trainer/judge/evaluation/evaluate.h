// SPDX-License-Identifier: MIT
// The strict test: an estimator gets the noisy outputs of every trajectory of a set, once, and its estimates are
// compared with the truth.
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
  std::string name;  ///< name in tables and in JSON
  codegen::Model model;
};

/// Called with the finished share of all work and the name of the current work. One call at a time, from any thread.
using StudyProgress = std::function<void(double share, const std::string& what)>;

/// Returns causal estimates over one run from a reset:
///   outputs  n_y x N  as measured
///   inputs   n_u x N  inputs of the plant, without noise; 0 x 0 without inputs
///   time_s   N
using Estimator = std::function<Estimates(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                          const Eigen::VectorXd& time_s)>;

/// An estimator that gets the number of the run in the test set.
using RunEstimator = std::function<Estimates(std::size_t run, const Eigen::MatrixXd& outputs)>;

/// Makes an estimator. Each thread makes its own, so that it may keep work memory.
using EstimatorFactory = std::function<Estimator()>;

/// One run of the test, kept for plots.
struct EvaluatedRun {
  Trajectory truth;              ///< clean outputs and states
  Eigen::MatrixXd measured;      ///< n_y x N, readings of the estimator
  Eigen::MatrixXd estimate;      ///< n_x x N
  std::string why = {};          ///< "first", "best", "worst": reason why it is an example; may be empty
  Eigen::VectorXd outside = {};  ///< N: 1 if z is outside of the training domain; size 0: unknown
  /// Estimates of all states of the model, if only some have a truth; 0 x 0: `estimate` has all states.
  Eigen::MatrixXd all_estimates = {};
};

/// Number of samples at which z was in the training domain. The first sample of each run is counted separately, because
/// z is the observer's initial value there.
struct DomainShare {
  std::int64_t samples = 0, inside = 0;  ///< samples after the first of each run
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
  std::optional<DomainShare> domain = {};                            ///< share of samples in the observer's domain
  std::string label = {};                   ///< name of the estimator for readers, if it is not clear by itself
  std::optional<ClosedLoopCost> loop = {};  ///< cost of an estimator in its own loop
  std::optional<Coverage> coverage = {};    ///< intervals of an estimator that reports its error
  double worst = 0.0;                       ///< largest norm of a run
  std::size_t worst_run = 0;                ///< number of that run in the test set
  std::string changed = {};                 ///< changes of the plant since the training: KEY=VALUE, ...
};

/// Adds strict noise (measurement_noise.h) to `clean` and runs the estimator. If it gives intervals, the result has
/// their coverage. `threads` 0: all cores. The result has the same bytes for any number of threads. If the units of the
/// states differ, norms use states divided by their deviation in `clean`, unless `config` has a state_scale.
Evaluation evaluate_runs(const std::string& estimator, const std::function<RunEstimator()>& factory,
                         const Dataset& clean, const NoiseConfig& noise, std::uint64_t seed, int threads,
                         const MetricsConfig& config = {});
Evaluation evaluate(const std::string& estimator, const EstimatorFactory& factory, const Dataset& clean,
                    const NoiseConfig& noise, std::uint64_t seed, int threads, const MetricsConfig& config = {});

/// Runs a model over one run in float, as in flight. The arguments are those of an Estimator. Only a model with phi(z)
/// u (25) reads the inputs. Two threads must not share it.
///   gate  if given, the model's monitor (which it must have) watches each step, and the run of a model with an error
///   head also has widened_sigma; kUsed: outputs pass the gate of the monitor
using ObserverRun = std::function<codegen::Run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                               const Eigen::VectorXd& time_s)>;
ObserverRun observer_run(const codegen::Model& model, bool uniform_steps, std::optional<codegen::Gate> gate = {});

/// Returns true if every step of the data is the model's sample period, so that time stamps are not needed.
bool has_uniform_steps(const Dataset& dataset, const codegen::Model& model);

/// Adds a run's samples inside and outside of the model's domain.
void count_domain(const codegen::Run& run, DomainShare& share);

/// Returns an estimator by observer_run().
EstimatorFactory observer_estimator(const codegen::Model& model, bool uniform_steps);

/// Returns the linear readout of the model's features, fitted on `training`, whose outputs have noise.
///   settled_from_s  see LinearReadout
EstimatorFactory readout_estimator(const codegen::Model& model, const Dataset& training, double settled_from_s);

/// Returns an estimator without a plant or a model, fitted in the same way: the LogBaseline "constant" (the mean state)
/// or "static_ridge". Samples that do not arrive are held.
EstimatorFactory baseline_estimator(std::string_view name, const Dataset& training);

/// Returns one of simple_names(), fitted in the same way: "ridge" is the readout of the model, the others are
/// baselines.
EstimatorFactory simple_estimator(std::string_view name, const codegen::Model& model, const Dataset& training,
                                  double settled_from_s);

/// Evaluates a model, with its domain. Its examples also show where z leaves the domain.
Evaluation evaluate_on_plant(const codegen::Model& model, const Dataset& clean, const NoiseConfig& noise,
                             std::uint64_t seed, int threads, const MetricsConfig& config = {});

}  // namespace nlo::trainer
