// SPDX-License-Identifier: MIT
// Measures the time of one sample: one step of the latent state and one estimate. Each estimate feeds the next
// measurement, so that no part of a sample can start before the previous sample is complete. In the same run, on the
// same weights: plain loops and fixed-size Eigen products (with and without -ffast-math), the time to load the weights
// from L1, many plants at once, and all of it with the weights pushed out of L1 and out of L2. Ends with the ratios.
//   step_latency [--json FILE] [--smoke] [--benchmark_filter=...]      the fastest of several repetitions counts
#include <benchmark/benchmark.h>
#include <nlo/kernels/weight.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bench/cache.h"
#include "bench/dependent_samples.h"
#include "bench/latency_table.h"
#include "bench/machine_peak.h"
#include "bench/random_error_head.h"
#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "bench/references.h"

namespace {

using nlo::Activation;
using nlo::bench::FastestReporter;
using nlo::bench::kFleet;
using nlo::bench::Sample;
using nlo::bench::sample_of;
using nlo::bench::sample_of_fleet;
using nlo::bench::sample_with;
using nlo::bench::Table;

// NLO_BENCH_PORTABLE: the build is for any CPU of this architecture. Its value is the factor by which observers may be
// slower.
#if defined(NLO_BENCH_PORTABLE)
constexpr bool kNative = false;
constexpr double kMayTake = NLO_BENCH_PORTABLE;
#else
constexpr bool kNative = true;
constexpr double kMayTake = 1.0;
#endif
constexpr std::size_t kPastL1 = 256 << 10, kPastL2 = 6 << 20;

/// How long each benchmark runs. With --smoke it runs once.
struct Effort {
  int repetitions = 7;
  int cold_in_l2 = 400, cold_in_l3 = 60;  // number of samples; other memory is read before each
  // [s]; the library's half a second is not needed, because the fastest repetition counts
  const char* min_time = "0.02";
} effort;

/// Returns the time of two readings of the clock [s].
double clock_time() {
  double fastest = 1.0;
  for (int k = 0; k < 1000; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    fastest = std::min(fastest, elapsed.count());
  }
  return fastest;
}

void add(const std::string& network, const std::string& what, const Sample& sample) {
  benchmark::RegisterBenchmark((network + "/" + what).c_str(), [sample](benchmark::State& state) {
    for (auto _ : state) sample();
  })->Repetitions(effort.repetitions);
}

/// Times samples, before each of which this much other memory is read.
void add_cold(const std::string& network, const std::string& what, const Sample& sample) {
  for (const auto& [cache, bytes] : {std::pair{", from L2", kPastL1}, std::pair{", from L3", kPastL2}}) {
    benchmark::RegisterBenchmark((network + "/" + what + cache).c_str(),
                                 [sample, bytes = bytes](benchmark::State& state) {
                                   nlo::bench::Evictor other(bytes);
                                   const double clock_s = clock_time();
                                   for (auto _ : state) {
                                     other.evict();
                                     const auto start = std::chrono::steady_clock::now();
                                     sample();
                                     const std::chrono::duration<double> elapsed =
                                         std::chrono::steady_clock::now() - start;
                                     state.SetIterationTime(std::max(elapsed.count() - clock_s, 1e-9));
                                   }
                                 })
        ->Repetitions(effort.repetitions)
        ->UseManualTime()
        ->Iterations(bytes == kPastL1 ? effort.cold_in_l2 : effort.cold_in_l3);
  }
}

/// Adds benchmarks of the network as plain loops and with Eigen.
template <class Model>
void add_references(const std::string& network, const Model& model, Activation kind, int width, int depth, bool cold) {
  const auto plain = nlo::bench::plain_references(kind, width, depth);
  const auto fast = nlo::bench::fast_math_references(kind, width, depth);
  add(network, "naive loops", sample_with(model, plain.naive));
  add(network, "naive loops, -ffast-math", sample_with(model, fast.naive));
  for (const auto& [what, evaluate] : {std::pair{"Eigen, rows", plain.eigen_rows},
                                       {"Eigen, columns", plain.eigen_columns},
                                       {"Eigen, rows, -ffast-math", fast.eigen_rows},
                                       {"Eigen, columns, -ffast-math", fast.eigen_columns}}) {
    add(network, what, sample_with(model, evaluate));
    if (cold) add_cold(network, what, sample_with(model, evaluate));
  }
}

template <class Model>
void add_observer(const std::string& network, const std::string& what, const Model& model, bool cold) {
  add(network, what, sample_of<nlo::KklObserver<Model>>(model));
  if (cold) add_cold(network, what, sample_of<nlo::KklObserver<Model>>(model));
}

/// Adds all benchmarks for networks of the paper's size.
template <Activation kKind>
void add_paper_network(const std::string& network) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, 50, 4>();
  add_observer(network, "nlo", kModel, true);
  if constexpr (kKind == Activation::kTanh || kKind == Activation::kRelu) {
    add_references(network, kModel, kKind, 50, 4, true);
  }
  constexpr std::size_t kBytes = sizeof(kModel.inverse_map.mlp) / 512 * 512;
  struct alignas(64) Line {
    char bytes[64];
  };
  const auto lines = std::make_shared<std::vector<Line>>(kBytes / sizeof(Line));
  for (Line& line : *lines) line.bytes[0] = 1;  // writes each line, see Evictor
  add(network, "loading the weights from L1", [lines] { nlo::bench::load_all(lines->data(), kBytes); });
  add(network, "nlo, 32 plants", sample_of_fleet(kModel));
}

constexpr const char* kWithError = "nlo, with the error's standard deviation";

template <Activation kKind, int kWidth, int kDepth>
void add_error_head(const std::string& network) {
  static constexpr auto kModel = nlo::bench::random_sure_kkl_model<kKind, kWidth, kDepth>();
  add(network, kWithError, sample_of<nlo::KklObserver<std::remove_cvref_t<decltype(kModel)>>>(kModel));
}

template <Activation kKind, int kWidth>
void add_small_network(const std::string& network) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, 2>();
  add_observer(network, "nlo", kModel, false);
  add_references(network, kModel, kKind, kWidth, 2, false);
}

template <class Weight>
void add_half_weights(const std::string& network, const std::string& what) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<Activation::kTanh, 50, 4, Weight>();
  add_observer(network, what, kModel, true);
}

constexpr const char* kGatedNetwork = "32 gated units, 32-32-2 tanh";

/// Adds the other structures with networks of 2 x 16, each evaluated four times per step, and gated units.
void add_structures() {
  static constexpr auto kLuenberger = nlo::bench::random_luenberger_model<Activation::kTanh, 16, 2>();
  static constexpr auto kGeneral = nlo::bench::random_general_model<Activation::kTanh, 16, 2>();
  static constexpr auto kDriven = nlo::bench::random_driven_model<Activation::kTanh, 16, 2>();
  const std::string network = "16x2 tanh";
  add(network, "luenberger",
      sample_of<nlo::LuenbergerObserver<std::remove_cvref_t<decltype(kLuenberger)>>>(kLuenberger));
  add(network, "general", sample_of<nlo::GeneralObserver<std::remove_cvref_t<decltype(kGeneral)>>>(kGeneral));
  add(network, "driven KKL", sample_of<nlo::DrivenKklObserver<std::remove_cvref_t<decltype(kDriven)>>>(kDriven));
  static constexpr auto kGated = nlo::bench::random_gated_model<32>();
  add(kGatedNetwork, "nlo", sample_of<nlo::GatedObserver<std::remove_cvref_t<decltype(kGated)>>>(kGated));
  static constexpr auto kSure = nlo::bench::random_sure_gated_model<32>();
  add(kGatedNetwork, kWithError, sample_of<nlo::GatedObserver<std::remove_cvref_t<decltype(kSure)>>>(kSure));
}

std::vector<std::string> all_eigen(const std::string& cache) {
  return {"Eigen, rows" + cache, "Eigen, columns" + cache, "Eigen, rows, -ffast-math" + cache,
          "Eigen, columns, -ffast-math" + cache};
}

void add_reference_ratios(Table& table, const std::string& network, const std::string& cache, double eigen_target,
                          double naive_target) {
  table.add(network, all_eigen(cache), "nlo" + cache, kNative ? eigen_target : 0.0, "best Eigen / nlo" + cache);
  if (!cache.empty()) return;
  table.add(network, {"naive loops, -ffast-math"}, "nlo", kNative ? naive_target : 0.0,
            "naive loops, -ffast-math / nlo");
  table.add(network, {"naive loops"}, "nlo", 0.0, "naive loops / nlo");
}

/// Returns the multiply-adds of `plants` networks of the paper's size in `ns`, relative to the peak of this machine's
/// units.
double share_of_peak(int plants, double ns) {
  constexpr double kMultiplyAdds = 3 * 50 + 3 * 50 * 50 + 50 * 2;
  return 2.0 * kMultiplyAdds * plants / (ns * 1e-9) / nlo::bench::peak_flops_of_one_thread<float>();
}

void add_paper_ratios(Table& table, const FastestReporter& times, const std::string& network, bool relu) {
  add_reference_ratios(table, network, "", 2.0, relu ? 1.5 : 2.0);
  for (const std::string cache : {", from L2", ", from L3"}) add_reference_ratios(table, network, cache, 1.5, 0.0);
  table.add(network, {"loading the weights from L1"}, "nlo", relu ? 1 / 1.25 / kMayTake : 0.0,
            "loading the weights from L1 / nlo");
  table.add(network, {"nlo, 32 plants"}, "nlo", relu ? 0.0 : 1 / 1.35 / kMayTake, "one plant of 32 / one alone",
            1.0 / kFleet);
  const double fleet_ns = times.ns(network, "nlo, 32 plants");
  if (kNative && fleet_ns > 0.0) {  // the peak is measured with the vectors of this compilation
    table.add_value(network + ": 32 plants, share of the multiply-add peak", share_of_peak(kFleet, fleet_ns),
                    relu ? 0.9 : 0.75);
  }
}

}  // namespace

int main(int argc, char** argv) {
  nlo::bench::Ratios ratios(NLO_BENCH_NAME, argc, argv);
  if (ratios.smoke()) effort = {.repetitions = 1, .cold_in_l2 = 2, .cold_in_l3 = 2, .min_time = "0.0001"};
  std::string min_time = std::string("--benchmark_min_time=") + effort.min_time;
  std::vector<char*> arguments(argv, argv + argc);
  arguments.insert(arguments.begin() + 1, min_time.data());
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;

  const std::string relu = "3-50x4-2 relu";
  const std::string tanhs[] = {"3-50x4-2 tanh", "3-50x4-2 tanh within 5e-6", "3-50x4-2 tanh within 5e-5"};
  const std::string small[] = {"3-32x2-2 tanh", "3-32x2-2 relu", "3-16x2-2 tanh", "3-16x2-2 relu"};
  add_paper_network<Activation::kTanh>(tanhs[0]);
  add_paper_network<Activation::kRelu>(relu);
  if constexpr (kNative) {
    add_paper_network<Activation::kTanh5e6>(tanhs[1]);
    add_paper_network<Activation::kTanh5e5>(tanhs[2]);
    add_half_weights<nlo::Bfloat16>(tanhs[0], "nlo, bf16 weights");
    add_half_weights<nlo::Float16>(tanhs[0], "nlo, fp16 weights");
    add_small_network<Activation::kTanh, 32>(small[0]);
    add_small_network<Activation::kRelu, 32>(small[1]);
    add_small_network<Activation::kTanh, 16>(small[2]);
    add_small_network<Activation::kRelu, 16>(small[3]);
    add_structures();
    add_error_head<Activation::kTanh, 50, 4>(tanhs[0]);
    add_error_head<Activation::kRelu, 50, 4>(relu);
    add_error_head<Activation::kTanh, 32, 2>(small[0]);
    add_error_head<Activation::kTanh, 16, 2>(small[2]);
  }

  FastestReporter times;
  benchmark::RunSpecifiedBenchmarks(&times);
  benchmark::Shutdown();
  std::fputc('\n', stderr);
  times.print();
  std::printf("\nRatios: the larger, the better for nlo\n");
  Table table(times, ratios);
  add_paper_ratios(table, times, relu, true);
  for (const std::string& network : tanhs) add_paper_ratios(table, times, network, false);
  for (const std::string& network : small) add_reference_ratios(table, network, "", 1.5, 0.0);
  if (times.ns(kGatedNetwork, "nlo") > 0.0)
    table.add_value(std::string(tanhs[0]) + " / " + kGatedNetwork,
                    times.ns(tanhs[0], "nlo") / times.ns(kGatedNetwork, "nlo"), kNative ? 1 / 1.3 : 0.0);
  for (const std::string& network : {tanhs[0], relu, small[0], small[2], std::string(kGatedNetwork)})
    table.add(network, {"nlo"}, kWithError, network == tanhs[0] || network == relu ? 1 / 1.1 : 0.0,
              "estimate / estimate with its error");
  for (const std::string half : {"bf16", "fp16"}) {
    for (const std::string cache : {"", ", from L2", ", from L3"}) {
      table.add(tanhs[0], {"nlo" + cache}, "nlo, " + half + " weights" + cache, cache == ", from L3" ? 1.0 : 0.0,
                "float weights / " + half + " weights" + cache);
    }
    table.add(tanhs[0], all_eigen(", from L3"), "nlo, " + half + " weights, from L3", 1.5,
              "best Eigen / nlo with " + half + " weights, from L3");
  }
  return ratios.write();
}
