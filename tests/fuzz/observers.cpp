// SPDX-License-Identifier: MIT
// Observers and monitors, driven by the bytes of the fuzzer: the first byte chooses the observer, the others are
// events.
#include "tests/fuzz/flight.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nlo::hostile;
  if (size == 0) return 0;
  Bits bits(bytes + 1, size - 1);
  kFleet[bytes[0] % kFleetSize].fly(bits, 1000);
  return 0;
}
