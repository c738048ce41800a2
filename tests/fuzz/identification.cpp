// SPDX-License-Identifier: MIT
// The file of an identification: equations to compile, names to find, initial ranges.
#include "trainer/experiments/load_identification.h"

#include "tests/fuzz/fuzz.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzzing::accepts([&] { (void)trainer::parse_identification(fuzzing::text_of(bytes, size), "i.toml"); });
  return 0;
}
