// SPDX-License-Identifier: MIT
// The runtime for the instruction set that the compiler was told of. With a namespace of its own: one program must not
// have functions of one name compiled in two ways.
#define nlo NLO_TEST_NAMESPACE
#include "tests/runtime/instruction_set_run.h"

#if defined(__AVX512F__)
instruction_set::Bits instruction_set::bits_of_avx512() {
  return nlo::testing::run_networks();
}
#else
instruction_set::Bits instruction_set::bits_of_avx2() {
  return nlo::testing::run_networks();
}
#endif
