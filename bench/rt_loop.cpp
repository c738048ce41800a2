// SPDX-License-Identifier: MIT
// Runs an observer of the paper's size in a periodic loop, and measures how late and how evenly it wakes, and how long
// step + estimate take in each tick. Beside it, the same calls run back to back. Uses SCHED_FIFO and locked memory if
// permitted.
//   usage: rt_loop [--rate 1000] [--seconds 10] [--calls 1000000] [--plot rt_loop.svg] [--json FILE] [--smoke]
#include <nlo/kkl_observer.h>
#include <sys/resource.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "bench/distribution.h"
#include "bench/random_model.h"
#include "bench/ratios.h"
#include "examples/control_loop/periodic_timer.h"

namespace {

using nlo::Activation;
using nlo::bench::Distribution;

constexpr auto kModel = nlo::bench::random_kkl_model<Activation::kTanh, 50, 4>();
constinit nlo::KklObserver observer{kModel};
float y = 1.0F;  // depends on the last estimate, so that no part of a tick can start before it

struct Options {
  double rate_hz = 1000.0, seconds = 10.0;
  std::size_t calls = 1'000'000;
  std::string plot = "rt_loop.svg";
};

constexpr char kUsage[] =
    "usage: rt_loop [--rate 1000] [--seconds 10] [--calls 1000000] [--plot rt_loop.svg] [--json FILE] [--smoke]\n"
    "  --rate   ticks per second, from 1 to 100000\n"
    "  --calls  of step and estimate, back to back\n"
    "  --plot   where to draw the histograms\n";

bool read_options(int argc, char** argv, Options& options) {
  const auto read = [](std::string_view text, auto& number, auto least, auto most) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size() && number >= least && number <= most;
  };
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i], value = argv[i + 1];
    bool good = true;
    if (name == "--rate") {
      good = read(value, options.rate_hz, 1.0, 100e3);
    } else if (name == "--seconds") {
      good = read(value, options.seconds, 0.01, 3600.0);
    } else if (name == "--calls") {
      good = read(value, options.calls, std::size_t{1000}, std::size_t{1'000'000'000});
    } else if (name == "--plot") {
      options.plot = value;
    } else {
      good = false;
    }
    if (!good) return false;
  }
  return argc % 2 == 1;
}

void step_and_estimate() {
  const auto status = static_cast<int>(observer.step(y));
  const auto x_hat = observer.estimate();
  y = 0.5F * x_hat[0] + 0.1F;
  // The estimate is complete before the clock is read again.
  asm volatile("" : : "r"(status), "m"(x_hat), "m"(y) : "memory");
}

template <class Call>
void time_calls(Distribution& durations, std::size_t calls, const Call& call) {
  for (int warm_up = 0; warm_up < 1000; ++warm_up) call();
  for (std::size_t i = 0; i < calls; ++i) {
    const auto start_ns = monotonic_ns();
    call();
    durations.add(monotonic_ns() - start_ns);
  }
  durations.sort();
}

void print_row(const Distribution& sorted, double unit_ns, const char* unit) {
  std::printf("%-32s", sorted.name().c_str());
  for (const double share : {0.5, 0.9, 0.99, 0.999, 1.0}) std::printf(" %9.4g", sorted.quantile_ns(share) / unit_ns);
  std::printf("  %s\n", unit);
}

}  // namespace

int main(int argc, char** argv) {
  nlo::bench::Ratios ratios(NLO_BENCH_NAME, argc, argv);
  Options options;
  if (ratios.smoke()) options = {.rate_hz = 1000.0, .seconds = 0.2, .calls = 1000, .plot = "rt_loop.svg"};
  if (!read_options(argc, argv, options)) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  const auto ticks = static_cast<std::size_t>(options.rate_hz * options.seconds);
  const auto period_ns = static_cast<std::int64_t>(1e9 / options.rate_hz);
  Distribution clock("clock alone", options.calls), hot("back to back", options.calls);
  Distribution in_loop("in the loop", ticks), late("woken after its deadline", ticks);
  Distribution jitter("period, off by", ticks);

  const bool locked = lock_memory();
  const bool real_time = use_real_time_priority();
  std::printf("3-50x4-2 tanh at %g Hz for %g s; %s; %s\n\n", options.rate_hz, options.seconds,
              real_time ? "SCHED_FIFO" : "ordinary scheduling (SCHED_FIFO is not permitted)",
              locked ? "memory locked" : "memory not locked (not permitted)");
  std::fflush(stdout);

  time_calls(clock, options.calls, [] {});
  time_calls(hot, options.calls, step_and_estimate);

  rusage before{}, after{};
  getrusage(RUSAGE_THREAD, &before);
  PeriodicTimer timer(period_ns);
  std::int64_t last_wake_ns = 0;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    const int periods = timer.wait();
    const auto start_ns = monotonic_ns();
    step_and_estimate();
    in_loop.add(monotonic_ns() - start_ns);
    late.add(timer.lateness_ns());
    const auto wake_ns = timer.deadline_ns() + timer.lateness_ns();
    if (tick > 0 && periods == 1) jitter.add(std::abs(wake_ns - last_wake_ns - period_ns));
    last_wake_ns = wake_ns;
  }
  getrusage(RUSAGE_THREAD, &after);
  for (Distribution* distribution : {&in_loop, &late, &jitter}) distribution->sort();

  std::printf("%-32s %9s %9s %9s %9s %9s\n", "", "p50", "p90", "p99", "p99.9", "max");
  std::printf("step + estimate\n");
  for (const Distribution* row : {&clock, &hot, &in_loop}) print_row(*row, 1.0, "ns");
  std::printf("the loop\n");
  for (const Distribution* row : {&late, &jitter}) print_row(*row, 1e3, "us");
  std::printf("%-32s %d of %zu\n", "missed deadlines", timer.missed(), ticks);
  std::printf("%-32s %ld; the system took the core away %ld times\n\n", "page faults in the loop",
              after.ru_minflt + after.ru_majflt - before.ru_minflt - before.ru_majflt,
              after.ru_nivcsw - before.ru_nivcsw);

  const std::string failure = nlo::bench::draw_histograms(
      {{"step + estimate, 3-50x4-2 tanh", {&hot, &in_loop}}, {"the loop's timer", {&late, &jitter}}}, options.plot);
  std::printf("%s%s\n", failure.empty() ? "histograms: " : "no histograms: ",
              failure.empty() ? options.plot.c_str() : failure.c_str());

  ratios.add("back to back: p50 / p99", hot.quantile_ns(0.5) / hot.quantile_ns(0.99));
  ratios.add("p50 back to back / p50 in the loop", hot.quantile_ns(0.5) / in_loop.quantile_ns(0.5));
  return ratios.write();
}
