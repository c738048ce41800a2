// SPDX-License-Identifier: MIT
// A program that only runs an observer, to measure its size.
#include "bench/embedded/fly.h"

int main() {
  for (;;) step_and_estimate();
}
