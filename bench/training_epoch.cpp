// SPDX-License-Identifier: MIT
// One full-batch epoch of the paper's Example 2: 50 trajectories of 2,501 samples, T* of 3-50x4-2 tanh, learned
// eigenvalues, noise drawn afresh; loss and gradient of every sample, then Adam. Beside it, what the machine could do.
//   usage: training_epoch [EPOCHS] [--json FILE]     (10 unless given; the fastest and the median are shown)
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
#include "trainer/config.h"
#include "trainer/data/dataset.h"
#include "trainer/nn/network.h"
#include "trainer/objective.h"
#include "trainer/optim/optimiser.h"
#include "trainer/parallel.h"
#include "trainer/structures/structure.h"

namespace {

using namespace nlo::trainer;

/// Van der Pol (22) from the paper's box, by the paper's RK4.
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
      const Eigen::Vector2d a = derivative(x);
      const Eigen::Vector2d b = derivative(x + 0.5 * kPeriod_s * a);
      const Eigen::Vector2d c = derivative(x + 0.5 * kPeriod_s * b);
      const Eigen::Vector2d d = derivative(x + kPeriod_s * c);
      x += kPeriod_s / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    run.outputs = run.states.row(0);
    dataset.trajectories.push_back(std::move(run));
  }
  return dataset;
}

/// Seconds of each epoch, sorted.
std::vector<double> time_epochs(const Experiment& experiment, const Dataset& dataset, int threads, int epochs) {
  const TrainingData data(dataset);
  ObserverStructure structure = make_structure(experiment, dataset.outputs, dataset.states);
  ThreadPool pool(threads);
  Objective objective(experiment, structure, data, pool);
  const std::vector<float> eigenvalues = parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data());
  Rollout& rollout = objective.roll_out_all(eigenvalues.data());
  normalise(structure, rollout);
  std::vector<float> parameters = initial_parameters(structure, experiment, rollout);
  std::vector<float> gradient(parameters.size());
  Optimiser optimiser("adam", {{structure.parameters(), 1e-3, 0.0}});

  std::vector<double> seconds;
  for (int epoch = -1; epoch < epochs; ++epoch) {  // the first one touches memory for the first time
    const auto start = std::chrono::steady_clock::now();
    objective.evaluate(parameters.data(), epoch + 1, gradient.data());
    optimiser.step(parameters.data(), gradient.data(), epoch + 1, 1.0);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (epoch >= 0) seconds.push_back(elapsed.count());
  }
  std::ranges::sort(seconds);
  return seconds;
}

}  // namespace

int main(int argc, char** argv) {
  nlo::bench::Ratios ratios(NLO_BENCH_NAME, argc, argv);
  int epochs = 10;
  if (argc > 1) {
    const char* end = argv[1] + std::strlen(argv[1]);
    const auto [rest, error] = std::from_chars(argv[1], end, epochs);
    if (argc > 2 || error != std::errc{} || rest != end || epochs < 1) {
      std::fprintf(stderr, "usage: training_epoch [EPOCHS]   10 unless given\n");
      return 2;
    }
  }
  Experiment experiment;
  experiment.name = "van_der_pol";
  experiment.observer.eigenvalues = {-1.0, -2.0, -3.0};
  experiment.training.mode = "full_batch";
  experiment.training.noise = {NoiseKind::kGaussian, 0.5};
  const Dataset dataset = van_der_pol_dataset(50);

  // Forward one product per weight, backward two, less the first layer's input gradient, which the eigenvalues need
  // here too. Activations, latent filter and noise are not counted: they are overhead in this figure.
  const NetworkShape network = make_structure(experiment, dataset.outputs, dataset.states).network;
  const double samples = 50.0 * 2501.0;
  const double flop = 2.0 * 3.0 * static_cast<double>(multiply_adds(network)) * samples;
  std::printf("full batch, 50 x 2501 samples, 3-50x4-2 tanh: %.2f GFLOP per epoch in the network's products\n\n",
              flop * 1e-9);
  std::printf("threads   fastest [s]   median [s]   GFLOP/s   machine's peak   share of it\n");
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  for (int threads = 1; threads <= cores; threads *= 2) {
    const double peak = nlo::bench::peak_flops<float>(threads);
    const std::vector<double> seconds = time_epochs(experiment, dataset, threads, epochs);
    const double fastest = seconds.front();
    std::printf("%7d %13.4f %12.4f %9.1f %16.1f %12.0f %%\n", threads, fastest, seconds[seconds.size() / 2],
                1e-9 * flop / fastest, 1e-9 * peak, 100.0 * flop / fastest / peak);
    ratios.add("full batch, GFLOP/s / machine's peak, threads: " + std::to_string(threads), flop / fastest / peak);
  }
  return ratios.write();
}
