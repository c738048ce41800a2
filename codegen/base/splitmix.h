// SPDX-License-Identifier: MIT
// SplitMix64 (Steele, Lea, Flood 2014): random numbers for few draws, and a hash of 64 bits. The same on every
// platform.
#pragma once

#include <cstdint>

namespace nlo::codegen {

/// Mixes the bits of `x`: every bit of the result depends on every bit of `x`. A bijection.
constexpr std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Returns the next number of the sequence and advances `state`.
constexpr std::uint64_t splitmix64(std::uint64_t& state) {
  return mixed(state += 0x9e3779b97f4a7c15ULL);
}

}  // namespace nlo::codegen
