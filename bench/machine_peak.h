// SPDX-License-Identifier: MIT
// The peak rate of this machine's multiply-add units, the reference of the benchmarks.
#pragma once

#include <nlo/kernels/lane_sum.h>
#include <nlo/kernels/simd.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

// The compiler's constraint for a vector register in inline assembly.
#if defined(__x86_64__) || defined(__i386__)
#define NLO_VECTOR_REGISTER "x"
#elif defined(__aarch64__)
#define NLO_VECTOR_REGISTER "w"
#else
#define NLO_VECTOR_REGISTER "m"
#endif

namespace nlo::bench {

/// Returns the measured peak of one thread [flop/s]: independent chains of multiply-adds on registers, in the vector
/// width for which this file is compiled. The best of several bursts counts, because other programs only make it
/// slower.
template <class Scalar>
double peak_flops_of_one_thread() {
  using P = simd::Pack<Scalar>;
  constexpr int kChains = 10;  // a latency of 4 to 5 cycles x 2 units
  constexpr int kRounds = 200'000;
  double best = 0.0;
  for (int burst = 0; burst < 20; ++burst) {
    P sums[kChains];
    for (int c = 0; c < kChains; ++c) sums[c] = simd::broadcast<P>(static_cast<Scalar>(c));
    P factor = simd::broadcast<P>(Scalar(0.999));
    P term = simd::broadcast<P>(Scalar(0.001));
    const auto start = std::chrono::steady_clock::now();
    for (int round = 0; round < kRounds; ++round) {
      asm volatile(""
                   : "+" NLO_VECTOR_REGISTER(factor),
                     "+" NLO_VECTOR_REGISTER(term));  // keeps the compiler from solving the recurrence
      for (P& sum : sums) sum = sum * factor + term;
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    Scalar total{};
    for (const P& sum : sums) total += simd::sum<Scalar>(sum);
    asm volatile("" : : "m"(total));
    best = std::max(best, 2.0 * kRounds * kChains * simd::kLanes<Scalar> / elapsed.count());
  }
  return best;
}

/// Returns the peak rate of `threads` threads together.
template <class Scalar>
double peak_flops(int threads) {
  std::vector<double> each(static_cast<std::size_t>(threads));
  std::vector<std::thread> workers;
  for (double& flops : each) workers.emplace_back([&flops] { flops = peak_flops_of_one_thread<Scalar>(); });
  for (std::thread& worker : workers) worker.join();
  double sum = 0.0;
  for (const double flops : each) sum += flops;
  return sum;
}

#undef NLO_VECTOR_REGISTER

}  // namespace nlo::bench
