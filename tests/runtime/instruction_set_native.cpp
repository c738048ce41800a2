// SPDX-License-Identifier: MIT
// The runtime compiled for one instruction set. It has its own namespace, because a program must not contain functions
// with one name compiled in two ways.
#define nlo NLO_TEST_NAMESPACE
#include "tests/runtime/instruction_set_run.h"

instruction_set::Bits instruction_set::NLO_TEST_BITS() {
  return nlo::testing::run_networks();
}
