// SPDX-License-Identifier: MIT
// Numbers as text for the host's terminal, without the tens of kilobytes of printf.
#pragma once

#include <cstdint>

#include "semihosting.h"

namespace board {

inline void write(const char* text) {
  board_write(text);
}

/// Writes `value` in base 10 or 16, with at least `digits` digits.
inline void write(std::uint32_t value, std::uint32_t base = 10, int digits = 1) {
  char text[11];
  char* at = text + sizeof(text) - 1;
  *at = '\0';
  for (; value != 0 || digits > 0; value /= base, --digits) *--at = "0123456789abcdef"[value % base];
  write(at);
}

/// Writes three decimals, for |value| < 2e6.
inline void write(float value) {
  if (value < 0) write("-");
  const auto thousandths = static_cast<std::uint32_t>((value < 0 ? -value : value) * 1000.0F + 0.5F);
  write(thousandths / 1000);
  write(".");
  write(thousandths % 1000, 10, 3);
}

}  // namespace board
