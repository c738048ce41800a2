// SPDX-License-Identifier: MIT
// Output functions for the programs of this folder, on an emulated board (NLO_ON_BOARD) and on the host. Results of a
// long run are printed as a hash.
#pragma once

#include <bit>
#include <cstdint>

#if defined(NLO_ON_BOARD)
#include "toolchains/console.h"
#else
#include <cstdio>
namespace board {
inline void write(const char* text) {
  std::fputs(text, stdout);
}
inline void write(std::uint32_t value, unsigned base = 10, int digits = 1) {
  std::printf(base == 16 ? "%0*x" : "%0*u", digits, value);
}
}  // namespace board
#endif

namespace nlo::target {

/// FNV-1a hash over the bits of its arguments.
class Hash {
 public:
  void add(std::uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) value_ = (value_ ^ (word >> shift & 0xffU)) * 0x100000001b3U;
  }
  void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }

  void write() const {
    board::write(static_cast<std::uint32_t>(value_ >> 32), 16, 8);
    board::write(static_cast<std::uint32_t>(value_), 16, 8);
    board::write("\n");
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace nlo::target
