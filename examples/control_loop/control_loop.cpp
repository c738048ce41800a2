// SPDX-License-Identifier: MIT
// Runs an observer in a periodic thread with absolute deadlines: measures, steps, estimates. on_timer() has the ten
// lines that a control loop needs. The other code simulates the hardware and collects statistics.
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "periodic_timer.h"
#include "statistics.h"
#include "van_der_pol.h"  // generated: nlo export, or nlo_add_model() in CMake
#include "van_der_pol_rig.h"

using nlo::van_der_pol::kModel;
using nlo::van_der_pol::kMonitor;
using nlo::van_der_pol::Monitor;
using nlo::van_der_pol::Observer;

namespace {

constinit Observer observer{kModel};
constinit Monitor monitor{kMonitor};
int faults = 0;        // measurements that were clamped or replaced by the last good one
int outside = 0;       // estimates outside of the training domain
int alarms = 0;        // ticks with an alarm of the monitor
float command = 0.0F;  // output to the actuator

/// Runs one tick of the control law: everything that the timer interrupt of a firmware would do.
Observer::Estimate on_timer(float position, int periods) {
  if (periods != 1) monitor.reset();                           // the monitor expects steps of one sample period
  const float y = monitor.usable_outputs(position, observer);  // an outlier becomes a missing sample
  const auto status = periods == 1 ? observer.step(y)          // latent only: a few multiply-adds
                                   : observer.step(y, static_cast<float>(periods) * kModel.sample_period_s);
  if (status != nlo::StepStatus::kOk) ++faults;  // clamped or held: the state is finite in any case
  const auto x_hat = observer.estimate();        // T*(z)
  if (!observer.in_domain()) ++outside;          // a real loop would enter its safe mode
  if (monitor.watch(observer, x_hat) != nlo::Alarm::kNone) ++alarms;  // a real loop would enter its safe mode
  command = -1.2F * x_hat[0] - 0.8F * x_hat[1];
  return x_hat;
}

struct Options {
  double seconds = 10.0;
  double rate_hz = 1000.0;
  double noise = 0.5;
  std::uint64_t seed = 1;
  const char* json = nullptr;
};

constexpr char kUsage[] =
    "usage: control_loop [--seconds 10] [--rate 1000] [--noise 0.5] [--seed 1] [--json FILE]\n"
    "  --rate   ticks per second; each tick is one sample period of the plant\n"
    "  --noise  standard deviation of the position sensor\n"
    "  --json   also write the results there\n";

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

bool read_options(int argc, char** argv, Options& options) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i], value = argv[i + 1];
    bool good = true;
    if (name == "--seconds") {
      good = read_number(value, options.seconds) && options.seconds > 0.0 && options.seconds <= 3600.0;
    } else if (name == "--rate") {
      good = read_number(value, options.rate_hz) && options.rate_hz >= 1.0 && options.rate_hz <= 100e3;
    } else if (name == "--noise") {
      good = read_number(value, options.noise) && options.noise >= 0.0 && options.noise <= 1e3;
    } else if (name == "--seed") {
      good = read_number(value, options.seed);
    } else if (name == "--json") {
      options.json = argv[i + 1];
    } else {
      good = false;
    }
    if (!good) return false;
  }
  return argc % 2 == 1;
}

void print_durations(const char* what, const Durations& sorted, double unit_ns, const char* unit) {
  const auto in_unit = [&](double share) { return static_cast<double>(sorted.quantile(share)) / unit_ns; };
  std::printf("  %-22s p50 %.4g, p99 %.4g, p99.9 %.4g, max %.4g %s\n", what, in_unit(0.5), in_unit(0.99),
              in_unit(0.999), in_unit(1.0), unit);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!read_options(argc, argv, options)) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  constexpr double kRunS = 50.0, kTransientS = 10.0;  // plant time, as in the paper's evaluation
  const double sample_period_s = static_cast<double>(kModel.sample_period_s);
  const int ticks = static_cast<int>(options.seconds * options.rate_hz);
  const int ticks_per_run = static_cast<int>(kRunS / sample_period_s);
  const int transient_ticks = static_cast<int>(kTransientS / sample_period_s);
  std::printf(
      "Van der Pol oscillator, position measured with noise N(0, %g), at %g Hz for %g s.\n"
      "Each tick is one sample period of the model (%g ms), so the plant runs %.4g x as fast as the clock;\n"
      "after each %g s of plant time it starts again from a random state, and the observer from zero.\n\n",
      options.noise, options.rate_hz, options.seconds, 1e3 * sample_period_s, sample_period_s * options.rate_hz, kRunS);
  std::fflush(stdout);

  VanDerPolRig rig(sample_period_s, options.noise, options.seed);
  Durations latency(static_cast<std::size_t>(ticks)), lateness(static_cast<std::size_t>(ticks));
  RmsError error, settled_error, position_error, velocity_error;
  const bool locked = lock_memory();
  const bool real_time = use_real_time_priority();

  PeriodicTimer timer(static_cast<std::int64_t>(1e9 / options.rate_hz));
  for (int tick = 0, in_run = 0; tick < ticks; ++tick) {
    const int periods = timer.wait();
    in_run += periods;
    if (in_run >= ticks_per_run) {
      in_run = 0;
      rig.restart();
      observer.reset();
      monitor.reset();
    }
    const float position = rig.measure(periods);

    const auto start_ns = monotonic_ns();
    const Observer::Estimate x_hat = on_timer(position, periods);
    latency.add(monotonic_ns() - start_ns);

    lateness.add(timer.lateness_ns());
    const double e0 = rig.state()[0] - static_cast<double>(x_hat[0]);
    const double e1 = rig.state()[1] - static_cast<double>(x_hat[1]);
    error.add(e0 * e0 + e1 * e1);
    position_error.add(e0 * e0);
    velocity_error.add(e1 * e1);
    if (in_run >= transient_ticks) settled_error.add(e0 * e0 + e1 * e1);
  }
  latency.sort();
  lateness.sort();

  std::printf("  %-22s %.3f rms over all; %.3f after the first %g s of each run\n", "estimation error", error.value(),
              settled_error.value(), kTransientS);
  std::printf("  %-22s position %.3f (the sensor alone: %g), velocity %.3f (not measured)\n", "",
              position_error.value(), options.noise, velocity_error.value());
  print_durations("step + estimate", latency, 1.0, "ns");
  print_durations("woken after deadline", lateness, 1e3, "us");
  std::printf("  %-22s %d of %d\n", "missed deadlines", timer.missed(), ticks);
  std::printf("  %-22s %d measurements clamped or held, %d estimates outside the training domain, %d alarms\n", "flags",
              faults, outside, alarms);
  std::printf("  %-22s %s, memory %s\n", "scheduling", real_time ? "SCHED_FIFO" : "ordinary (SCHED_FIFO not permitted)",
              locked ? "locked" : "not locked (not permitted)");

  if (options.json) {
    std::FILE* file = std::fopen(options.json, "w");
    if (!file) {
      std::fprintf(stderr, "%s: cannot be written: %s\n", options.json, std::strerror(errno));
      return 1;
    }
    std::fprintf(file,
                 "{\n  \"rate_hz\": %g,\n  \"ticks\": %d,\n  \"sample_period_s\": %g,\n  \"noise_std\": %g,\n"
                 "  \"seed\": %llu,\n  \"rms_error\": %.6g,\n  \"settled_rms_error\": %.6g,\n"
                 "  \"missed_deadlines\": %d,\n  \"faults\": %d,\n  \"outside_domain\": %d,\n"
                 "  \"real_time_priority\": %s,\n  \"memory_locked\": %s,\n  \"step_and_estimate_ns\": %s,\n"
                 "  \"wake_up_lateness_ns\": %s,\n  \"step_and_estimate_histogram\": %s\n}\n",
                 options.rate_hz, ticks, sample_period_s, options.noise, static_cast<unsigned long long>(options.seed),
                 error.value(), settled_error.value(), timer.missed(), faults, outside, real_time ? "true" : "false",
                 locked ? "true" : "false", latency.to_json().c_str(), lateness.to_json().c_str(),
                 latency.histogram_json().c_str());
    if (std::fclose(file) != 0) {
      std::fprintf(stderr, "%s: could not be written completely: %s\n", options.json, std::strerror(errno));
      return 1;
    }
  }
  return 0;
}
