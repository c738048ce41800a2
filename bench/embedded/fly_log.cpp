// SPDX-License-Identifier: MIT
// Flies an exported observer over a whole log on an emulated board. flight.csv, written by `nlo evaluate --estimates`,
// has the inputs of each step and the estimates of the trainer's observer. Prints
//   samples N ok N domain N instructions N most N period N observer N
//     ok      steps with StepStatus::kOk
//     domain  samples where in_domain() agrees with the trainer's
//     instructions, most   of one step and estimate, mean and largest; the first is not counted, it starts the observer
//     period  instructions of a step without dt
//   state I apart N        for each state: the largest difference of the estimates over the RMS of the trainer's, in
//                          units of 1e-9
#include <cmath>
#include <cstdint>

#include "bench/embedded/fly_exported.h"
#include "bench/embedded/host_file.h"
#include "bench/embedded/instruction_clock.h"
#include "toolchains/console.h"

namespace {

constexpr int kMost = 64;  // largest number of columns

void write(const char* name, std::uint32_t value) {
  board::write(name);
  board::write(value);
}

int fail(const char* why) {
  board::write(why);
  return 1;
}

}  // namespace

int main() {
  const nlo::bench::InstructionClock clock;
  nlo::bench::HostFile file("flight.csv");
  if (!file.is_open() || !file.skip_line()) return fail("there is no flight.csv\n");

  const int columns = 2 + flown.outputs + flown.inputs + 2 * flown.states + 1;
  if (columns > kMost) return fail("too many channels\n");
  float row[kMost], x_hat[kMost], apart[kMost] = {};
  double squares[kMost] = {};
  const float *y = row + 2, *u = y + flown.outputs, *expected = u + flown.inputs, *domain = expected + flown.states;
  std::uint32_t samples = 0, ok = 0, domain_agrees = 0, most = 0;
  std::uint64_t all = 0;
  for (int count = file.read_line(row, kMost); count != 0; count = file.read_line(row, kMost)) {
    if (count != columns) return fail("flight.csv belongs to another observer\n");
    const std::uint32_t start = nlo::bench::count_now();
    const int status = step_and_estimate(row[1], y, u, x_hat);
    const std::uint32_t taken = nlo::bench::ticks_since(start);
    if (samples > 0) {
      all += taken;
      if (taken > most) most = taken;
    }
    ++samples;
    if (status == 0) ++ok;
    if (in_domain() == (*domain > 0.5F)) ++domain_agrees;
    for (int i = 0; i < flown.states; ++i) {
      const float difference = std::fabs(x_hat[i] - expected[i]);
      if (!(difference <= apart[i])) apart[i] = difference;  // keeps NaN
      squares[i] += static_cast<double>(expected[i]) * static_cast<double>(expected[i]);
    }
  }
  if (samples < 2) return fail("flight.csv has no samples, or ends within one\n");
  write("samples ", samples);
  write(" ok ", ok);
  write(" domain ", domain_agrees);
  write(" instructions ", clock.instructions(all, samples - 1));
  write(" most ", clock.instructions(most, 1));
  constexpr int kCalls = 50;
  const auto period = [&] { static_cast<void>(step_and_estimate(0.0F, y, u, x_hat)); };
  write(" period ", clock.instructions(nlo::bench::ticks(period, kCalls), kCalls));
  write(" observer ", flown.bytes);
  board::write("\n");
  for (int i = 0; i < flown.states; ++i) {
    const double relative = static_cast<double>(apart[i]) / std::sqrt(squares[i] / samples) * 1e9;
    write("state ", static_cast<std::uint32_t>(i + 1));
    write(" apart ", relative < 4e9 ? static_cast<std::uint32_t>(relative + 0.5) : 4'000'000'000U);
    board::write("\n");
  }
  return clock.counts() ? 0 : fail("the timer does not count instructions\n");
}
