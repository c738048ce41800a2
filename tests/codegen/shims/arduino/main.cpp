// SPDX-License-Identifier: MIT
// Runs a sketch as a program. SKETCH is its file.
#include <Arduino.h>
#include SKETCH

int main() {
  setup();
  for (int i = 0; i < 25000; ++i) loop();  // 2.5 s
}
