// SPDX-License-Identifier: MIT
// What one sample costs: step, estimate, and both in a loop in which each estimate feeds the next measurement. Beside
// it, in the same run, the same network as plain loops and as fixed-size Eigen products. Ends with the ratios.
#include <benchmark/benchmark.h>
#include <nlo/kkl_observer.h>

#include <cstdio>
#include <map>
#include <string>

#include "bench/machine_peak.h"
#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "bench/reference_networks.h"

namespace {

using nlo::Activation;

/// A measurement that depends on the last estimate: nothing of the next sample can start before this one is done.
float next_measurement(float x_hat) {
  return 0.5F * x_hat + 0.1F;
}

template <Activation kKind, int kWidth, int kDepth>
void step(benchmark::State& state) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>();
  nlo::KklObserver observer{kModel};
  float y = 1.0F;
  for (auto _ : state) {
    benchmark::DoNotOptimize(observer.step(y));
    y = next_measurement(observer.latent()[0]);
  }
}

template <Activation kKind, int kWidth, int kDepth>
void estimate(benchmark::State& state) {
  static constexpr auto kMap = nlo::bench::random_mlp<kKind, 3, kWidth, kDepth, 2>();
  float z[3] = {0.1F, 0.2F, 0.3F};
  float x_hat[2];
  for (auto _ : state) {
    kMap.evaluate(z, x_hat);
    z[0] = next_measurement(x_hat[0]);
    benchmark::DoNotOptimize(x_hat);
  }
}

template <Activation kKind, int kWidth, int kDepth>
void step_and_estimate(benchmark::State& state) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>();
  nlo::KklObserver observer{kModel};
  float y = 1.0F;
  for (auto _ : state) {
    benchmark::DoNotOptimize(observer.step(y));
    const auto x_hat = observer.estimate();
    y = next_measurement(x_hat[0]);
  }
  benchmark::DoNotOptimize(y);
}

/// One step and one estimate of an observer that is not plain KKL.
template <class Observer, class Model>
void structure(benchmark::State& state, const Model& model) {
  Observer observer{model};
  float y = 1.0F;
  for (auto _ : state) {
    if constexpr (Observer::kDriven) {
      benchmark::DoNotOptimize(observer.step(y, 0.1F));
    } else {
      benchmark::DoNotOptimize(observer.step(y));
    }
    y = next_measurement(observer.estimate()[0]);
  }
  benchmark::DoNotOptimize(y);
}

/// The other structures with networks of 2 x 16: four evaluations of each per step.
void add_structures() {
  static constexpr auto kLuenberger = nlo::bench::random_luenberger_model<Activation::kTanh, 16, 2>();
  static constexpr auto kGeneral = nlo::bench::random_general_model<Activation::kTanh, 16, 2>();
  static constexpr auto kDriven = nlo::bench::random_driven_model<Activation::kTanh, 16, 2>();
  benchmark::RegisterBenchmark("16x2 tanh/luenberger", [](benchmark::State& state) {
    structure<nlo::LuenbergerObserver<decltype(kLuenberger)>>(state, kLuenberger);
  });
  benchmark::RegisterBenchmark("16x2 tanh/general", [](benchmark::State& state) {
    structure<nlo::GeneralObserver<decltype(kGeneral)>>(state, kGeneral);
  });
  benchmark::RegisterBenchmark("16x2 tanh/driven KKL", [](benchmark::State& state) {
    structure<nlo::DrivenKklObserver<decltype(kDriven)>>(state, kDriven);
  });
}

/// step() of the runtime, then another network on its latent state.
template <class Network, class Model>
void step_and_evaluate(benchmark::State& state, const Network& network, const Model& model) {
  nlo::KklObserver observer{model};
  float y = 1.0F;
  float x_hat[2];
  for (auto _ : state) {
    benchmark::DoNotOptimize(observer.step(y));
    network.evaluate(observer.latent().data(), x_hat);
    y = next_measurement(x_hat[0]);
  }
  benchmark::DoNotOptimize(y);
}

template <Activation kKind, int kWidth, int kDepth>
void naive(benchmark::State& state) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>();
  static const auto network = nlo::bench::naive_network<kKind>(nlo::bench::random_layers<3, kWidth, kDepth, 2>());
  step_and_evaluate(state, network, kModel);
}

template <Activation kKind, int kWidth, int kDepth, int kOrder>
void eigen(benchmark::State& state) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>();
  static const auto network =
      nlo::bench::eigen_network<kKind, kOrder>(nlo::bench::random_layers<3, kWidth, kDepth, 2>());
  step_and_evaluate(state, network, kModel);
}

template <Activation kKind, int kWidth, int kDepth>
void add(const std::string& network) {
  const auto add_one = [&](const char* what, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark((network + "/" + what).c_str(), function);
  };
  add_one("step", step<kKind, kWidth, kDepth>);
  add_one("estimate", estimate<kKind, kWidth, kDepth>);
  add_one("step+estimate", step_and_estimate<kKind, kWidth, kDepth>);
  add_one("naive loops", naive<kKind, kWidth, kDepth>);
  add_one("Eigen, rows", eigen<kKind, kWidth, kDepth, Eigen::RowMajor>);
  add_one("Eigen, columns", eigen<kKind, kWidth, kDepth, Eigen::ColMajor>);
}

/// Google Benchmark's table, then the ratios to step+estimate per network.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  RatioReporter() : benchmark::ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      // With repetitions the median speaks for all.
      const bool single = run.run_type == Run::RT_Iteration && run.repetitions <= 1;
      if (!single && run.aggregate_name != "median") continue;
      const std::string name = run.run_name.function_name;
      const auto slash = name.find('/');
      times_ns_[name.substr(0, slash)][name.substr(slash + 1)] = run.GetAdjustedCPUTime();
    }
    benchmark::ConsoleReporter::ReportRuns(runs);
  }

  void Finalize() override {
    std::printf("\n%-14s %14s   %s\n", "network", "step+estimate", "the same with");
    for (const auto& [network, times] : times_ns_) {
      const auto own = times.find("step+estimate");
      if (own == times.end()) continue;
      std::printf("%-14s %11.1f ns  ", network.c_str(), own->second);
      for (const char* reference : {"naive loops", "Eigen, rows", "Eigen, columns"}) {
        const auto other = times.find(reference);
        if (other != times.end()) std::printf("   %s: %.1f x as long", reference, other->second / own->second);
      }
      std::printf("\n");
    }
  }

 private:
  std::map<std::string, std::map<std::string, double>> times_ns_;
};

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  char peak[64];
  std::snprintf(peak, sizeof peak, "%.1f GFLOP/s on one thread, %d floats to a vector",
                nlo::bench::peak_flops_of_one_thread<float>() * 1e-9, nlo::simd::kLanes<float>);
  benchmark::AddCustomContext("measured peak", peak);

  add<Activation::kTanh, 50, 4>("3-50x4-2 tanh");  // the paper's
  add<Activation::kRelu, 50, 4>("3-50x4-2 relu");
  add<Activation::kTanh, 32, 2>("3-32x2-2 tanh");
  add<Activation::kTanh, 16, 2>("3-16x2-2 tanh");
  add_structures();
  RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  return 0;
}
