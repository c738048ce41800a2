// SPDX-License-Identifier: MIT
// Ten million hostile steps, divided among all observers: see flight.h.
//   hostile_flight [MILLIONS] [SEED]
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/flight.h"

int main(int argc, char** argv) {
  using namespace nlo::hostile;
  const double millions = argc > 1 ? std::atof(argv[1]) : 10.0;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  const auto steps = static_cast<long>(1e6 * millions / kFleetSize) + 1;
  for (int i = 0; i < kFleetSize; ++i) {
    Bits bits(seed + 1000 * static_cast<std::uint64_t>(i));
    kFleet[i].fly(bits, steps);
    std::printf("%-28s %ld steps\n", kFleet[i].name, steps);
    std::fflush(stdout);
  }
  return 0;
}
