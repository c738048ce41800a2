// SPDX-License-Identifier: MIT
// A minimal Arduino core with a clock that advances by itself: enough to compile a generated sketch without the
// vendor's tools and to run it for some simulated seconds.
#pragma once

#include <stdint.h>
#include <stdio.h>

enum { A0 = 14 };

struct SimulatedBoard {
  uint32_t now_us = 0xffff0000U;  // micros() overflows soon
  uint32_t calls = 0;
};
inline SimulatedBoard& simulated_board() {
  static SimulatedBoard board;
  return board;
}

// Advances by 0.1 ms per call. Once, it advances by 65 ms, as if the loop had been busy.
inline uint32_t micros() {
  SimulatedBoard& board = simulated_board();
  board.now_us += ++board.calls == 5000 ? 65000U : 100U;
  return board.now_us;
}

// Returns 10 bits: a slow triangle around the middle.
inline int analogRead(int pin) {
  const int phase = static_cast<int>(simulated_board().calls / 16U % 400U) + pin - A0;
  return 412 + (phase < 200 ? phase : 400 - phase);
}

struct SimulatedSerial {
  void begin(unsigned long) {}
  void print(double value, int digits) { printf("%.*f", digits, value); }
  void print(char c) { putchar(c); }
  void print(const char* text) { printf("%s", text); }
  void println(const char* text = "") { printf("%s\n", text); }
};
inline SimulatedSerial& simulated_serial() {
  static SimulatedSerial serial;
  return serial;
}
#define Serial simulated_serial()
