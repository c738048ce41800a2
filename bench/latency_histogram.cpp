// SPDX-License-Identifier: MIT
// How long step + estimate takes, call by call: a control loop cares for the slowest, not for the mean.
//   usage: latency_histogram [CALLS]      (a million unless given)
#include <nlo/kkl_observer.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "bench/random_model.h"

namespace {

using Clock = std::chrono::steady_clock;
using nlo::Activation;

std::uint32_t ns_between(Clock::time_point start, Clock::time_point end) {
  return static_cast<std::uint32_t>(std::chrono::nanoseconds(end - start).count());
}

/// Sorted durations [ns] of `calls` calls.
template <class Call>
std::vector<std::uint32_t> time_calls(std::size_t calls, Call call) {
  for (int warm_up = 0; warm_up < 1000; ++warm_up) call();
  std::vector<std::uint32_t> durations_ns(calls);
  for (auto& duration_ns : durations_ns) {
    const auto start = Clock::now();
    call();
    duration_ns = ns_between(start, Clock::now());
  }
  std::ranges::sort(durations_ns);
  return durations_ns;
}

std::uint32_t quantile(const std::vector<std::uint32_t>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void print_row(const char* what, const std::vector<std::uint32_t>& sorted) {
  std::printf("%-16s %9u %9u %9u %9u\n", what, quantile(sorted, 0.5), quantile(sorted, 0.99), quantile(sorted, 0.999),
              sorted.back());
}

/// Buckets that grow by a quarter, from the median's half upwards; a bar is the logarithm of the count.
void print_histogram(const std::vector<std::uint32_t>& sorted) {
  double low = 0.5 * quantile(sorted, 0.5);
  auto first = sorted.begin();
  while (first != sorted.end()) {
    const double high = 1.25 * low;
    const auto last = std::lower_bound(first, sorted.end(), high, [](std::uint32_t a, double b) { return a < b; });
    const auto count = last - first;
    int bar = 0;
    for (auto left = count; left > 0; left /= 2) ++bar;
    if (count > 0)
      std::printf("  < %9.0f ns %9td  %s\n", high, count, std::string(static_cast<std::size_t>(bar), '#').c_str());
    first = last;
    low = high;
  }
}

template <Activation kKind, int kWidth, int kDepth>
std::vector<std::uint32_t> time_observer(std::size_t calls) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>();
  nlo::KklObserver observer{kModel};
  float y = 1.0F;
  return time_calls(calls, [&] {
    const auto status = static_cast<int>(observer.step(y));
    const auto x_hat = observer.estimate();
    y = 0.5F * x_hat[0] + 0.1F;
    // The estimate is complete before the clock is read again.
    asm volatile("" : : "r"(status), "m"(x_hat), "m"(y) : "memory");
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t calls = 1'000'000;
  if (argc > 1) {
    const char* end = argv[1] + std::strlen(argv[1]);
    const auto [rest, error] = std::from_chars(argv[1], end, calls);
    if (argc > 2 || error != std::errc{} || rest != end || calls < 1000) {
      std::fprintf(stderr, "usage: latency_histogram [CALLS]   at least 1000; a million unless given\n");
      return 2;
    }
  }
  std::printf("step + estimate over %zu calls, each timed alone [ns]\n\n", calls);
  std::printf("%-16s %9s %9s %9s %9s\n", "network", "p50", "p99", "p99.9", "max");
  print_row("(clock alone)", time_calls(calls, [] {}));
  print_row("3-16x2-2 tanh", time_observer<Activation::kTanh, 16, 2>(calls));
  print_row("3-32x2-2 tanh", time_observer<Activation::kTanh, 32, 2>(calls));
  print_row("3-50x4-2 relu", time_observer<Activation::kRelu, 50, 4>(calls));
  const auto paper = time_observer<Activation::kTanh, 50, 4>(calls);
  print_row("3-50x4-2 tanh", paper);
  std::printf("\n3-50x4-2 tanh, calls per duration (a bar grows by one when the count doubles)\n");
  print_histogram(paper);
  return 0;
}
