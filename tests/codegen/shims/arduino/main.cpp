// SPDX-License-Identifier: MIT
// A sketch as a program: SKETCH names it.
#include <Arduino.h>
#include SKETCH

int main() {
  setup();
  for (int i = 0; i < 25000; ++i) loop();  // 2.5 s
}
