// SPDX-License-Identifier: MIT
// A program that does nothing but fly, for its size.
#include "bench/embedded/fly.h"

int main() {
  for (;;) step_and_estimate();
}
