// SPDX-License-Identifier: MIT
// Times the training of the paper's Example 2: 50 trajectories of 2,501 samples, T* of 3-50x4-2 tanh, learned
// eigenvalues, new noise in each step; loss and gradient, then Adam. It runs full batches, 4,096 random samples of 32
// trajectories per step, and 32 gated units with T* of 32-32-2 on 16 segments of 20 s. The limit of the machine is
// measured in the same run.
//   usage: training_epoch [EPOCHS] [--json FILE] [--smoke]     (10 unless given; the fastest and the median are shown)
#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "bench/machine_peak.h"
#include "bench/ratios.h"
#include "bench/training_limit.h"
#include "codegen/reference/rk4.h"
#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/gradients/nn/network_shape.h"
#include "trainer/learn/optim/optimiser.h"
#include "trainer/learn/training/objective.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/unit_settings.h"

namespace {

using namespace nlo::trainer;

/// Returns runs of Van der Pol (22) from the paper's box, by the paper's RK4.
Dataset van_der_pol_dataset(int trajectories) {
  constexpr double kPeriod_s = 0.02;
  constexpr int kSamples = 2501;
  const auto derivative = [](const Eigen::Vector2d& x) {
    return Eigen::Vector2d(x(1), (1.0 - x(0) * x(0)) * x(1) - x(0));
  };
  Dataset dataset;
  dataset.outputs = {{.name = "x1", .unit = "", .wrap = 0.0}};
  dataset.states = {{.name = "x1", .unit = "", .wrap = 0.0}, {.name = "x2", .unit = "", .wrap = 0.0}};
  dataset.sample_period_s = kPeriod_s;
  for (int t = 0; t < trajectories; ++t) {
    Trajectory run;
    run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, kPeriod_s * (kSamples - 1));
    run.states.resize(2, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    Eigen::Vector2d x(-1.0 + 2.0 * t / (trajectories - 1.0), 1.0 - 0.04 * (t * 7 % trajectories));
    for (int k = 0; k < kSamples; ++k) {
      run.states.col(k) = x;
      x = nlo::codegen::rk4_step(x, kPeriod_s, [&](double, const Eigen::Vector2d& at) { return derivative(at); });
    }
    run.outputs = run.states.row(0);
    dataset.trajectories.push_back(std::move(run));
  }
  return dataset;
}

/// Returns the seconds of a step, sorted: each of `bursts` values is the mean of `steps` steps.
std::vector<double> time_steps(const Experiment& experiment, const Dataset& dataset, int threads, int bursts,
                               int steps) {
  const TrainingData data(dataset);
  ObserverStructure structure = make_structure(experiment, false, dataset.outputs, dataset.states);
  ThreadPool pool(threads);
  Objective objective(experiment, structure, data, pool);
  normalise_dynamics(structure, data, pool);
  const Rollout& rollout = objective.roll_out_flight(initial_dynamics(structure, experiment).data());
  normalise(structure, rollout);
  std::vector<float> parameters = initial_parameters(structure, experiment, rollout);
  std::vector<float> gradient(parameters.size());
  Optimiser optimiser("adam", {{structure.parameters(), 1e-3, 0.0}});

  long done = 0;
  std::vector<double> seconds;
  for (int burst = -1; burst < bursts; ++burst) {  // the first burst touches the memory for the first time
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i, ++done) {
      objective.evaluate(parameters.data(), done, gradient.data());
      optimiser.step(parameters.data(), gradient.data(), done, 1.0);
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (burst >= 0) seconds.push_back(elapsed.count() / steps);
  }
  std::ranges::sort(seconds);
  return seconds;
}

struct Workload {
  const char* name;  ///< name in the results
  TrainingMode config;
  double samples;  ///< number of samples per step
  int steps_per_burst;
  double reported_steps;  ///< number of steps whose time the table shows
  double limit_share;     ///< least ratio of the limit to the time of one core; 0: none
};

/// Seconds of one core per sample. Each is a bound or a reference for the network's share of a step.
struct Limits {
  double peak;   ///< multiply-adds at the measured peak, plus tanh: no code is faster on this machine
  double eigen;  ///< the products by Eigen, and tanh
  double own;    ///< passes of the trainer over one block in the cache
};

/// Limits of T* and of the network of gated units, each with tanh.
Limits measure_limits(const ObserverStructure& structure, int bursts) {
  std::vector<const NetworkShape*> networks = {&structure.network};
  if (!structure.dynamics.shape.layers.empty()) networks.push_back(&structure.dynamics.shape);
  Limits limits{};
  for (const NetworkShape* network : networks) {
    const nlo::bench::TrainingLimit limit = nlo::bench::training_limit(*network, bursts);
    const double products = 2.0 * nlo::bench::kPasses * static_cast<double>(multiply_adds(*network));
    const double gates = network == &structure.network ? 0.0 : network->outputs() * nlo::bench::tanh_seconds(bursts);
    limits.peak += products / nlo::bench::peak_flops_of_one_thread<float>() + limit.tanh + gates;
    limits.eigen += limit.eigen_products + limit.tanh + gates;
    limits.own += limit.own_passes;
  }
  return limits;
}

void run_mode(const Workload& mode, Experiment experiment, const Dataset& dataset, int bursts,
              nlo::bench::Ratios& ratios) {
  experiment.training.mode = mode.config;
  const Limits limits =
      measure_limits(make_structure(experiment, false, dataset.outputs, dataset.states), ratios.smoke() ? 1 : 40);
  const double scale = mode.reported_steps;
  std::printf("%s: seconds of one core for the network's share alone\n", mode.name);
  std::printf("  multiply-adds at the machine's peak, and tanh %12.4f   (the limit)\n",
              scale * mode.samples * limits.peak);
  std::printf("  Eigen's products, and tanh %31.4f\n", scale * mode.samples * limits.eigen);
  std::printf("  the trainer's own passes, one block in cache %13.4f\n\n", scale * mode.samples * limits.own);
  std::printf("threads   fastest [s]   median [s]   limit / fastest   one thread / this\n");
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  double one_thread = 0.0;
  for (int threads = 1; threads <= std::min(2, cores); ++threads) {
    const std::vector<double> seconds = time_steps(experiment, dataset, threads, bursts, mode.steps_per_burst);
    const double fastest = seconds.front();
    if (threads == 1) one_thread = fastest;
    const double share = mode.samples * limits.peak / threads / fastest;
    std::printf("%7d %13.4f %12.4f %17.2f %19.2f\n", threads, scale * fastest, scale * seconds[seconds.size() / 2],
                share, one_thread / fastest);
    const std::string name = mode.name;
    if (threads == 1) {
      ratios.add(name + ", one thread: machine's limit / ours", share, mode.limit_share);
      ratios.add(name + ", one thread: Eigen's products and tanh / ours", mode.samples * limits.eigen / fastest);
    } else {
      ratios.add(name + ": one thread / two threads", one_thread / fastest, mode.limit_share > 0.0 ? 1.8 : 0.0);
    }
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  nlo::bench::Ratios ratios(NLO_BENCH_NAME, argc, argv);
  int epochs = ratios.smoke() ? 1 : 10;
  if (argc > 1) {
    const char* end = argv[1] + std::strlen(argv[1]);
    const auto [rest, error] = std::from_chars(argv[1], end, epochs);
    if (argc > 2 || error != std::errc{} || rest != end || epochs < 1) {
      std::fprintf(stderr, "usage: training_epoch [EPOCHS] [--json FILE] [--smoke]   10 unless given\n");
      return 2;
    }
  }
  Experiment experiment;
  experiment.name = "van_der_pol";
  experiment.observer.eigenvalues = {-1.0, -2.0, -3.0};
  experiment.training.noise = {NoiseKind::kGaussian, 0.5};
  const int trajectories = ratios.smoke() ? 4 : 50, steps_per_burst = ratios.smoke() ? 1 : 100;
  const Dataset dataset = van_der_pol_dataset(trajectories);

  const Workload full{"full-batch epoch", TrainingMode::kFullBatch, trajectories * 2501.0, 1, 1.0, 0.75};
  const auto samples = static_cast<double>(experiment.training.samples_per_step);
  const Workload random{
      "1,000 steps of 4,096 samples", TrainingMode::kRandomSamples, samples, steps_per_burst, 1000.0, 0.75};
  run_mode(full, experiment, dataset, epochs, ratios);
  run_mode(random, experiment, dataset, epochs, ratios);

  experiment.observer.structure = "gated";
  experiment.observer.own.set<UnitSettings>() = {.units = 32, .rates = {0.3, 20.0}};
  experiment.inverse_map.hidden = {32};
  experiment.training.trajectories_per_step = 16;
  experiment.training.segment_s = 20.0;
  experiment.training.samples_per_step = 16'000;
  const Workload gated{
      "1,000 steps of 32 gated units", TrainingMode::kRandomSamples, 16'016.0, steps_per_burst / 10 + 1, 1000.0, 0.0};
  run_mode(gated, experiment, dataset, epochs, ratios);
  return ratios.write();
}
