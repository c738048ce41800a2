// SPDX-License-Identifier: MIT
// A choice without a branch: the deterministic policy takes as many instructions whatever is measured. A conditional
// operator does not promise that, compilers make branches of it where they guess that one side is usual.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "nlo/simd.h"

namespace nlo {

/// `yes` where the condition holds, else `no`, whatever they are: not a number too.
template <class T>
NLO_INLINE constexpr T select(bool condition, T yes, T no) {
  using Mask = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;  // at least a register wide
  using Small = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::uint16_t>;
  using Bits = std::conditional_t<sizeof(T) <= 2, Small, Mask>;
  // What the compiler cannot look into it cannot turn back into a branch.
  Mask mask = Mask{0} - Mask{condition};
  if (!std::is_constant_evaluated()) asm("" : "+r"(mask));
  const Mask from_yes = Mask{std::bit_cast<Bits>(yes)} & mask, from_no = Mask{std::bit_cast<Bits>(no)} & ~mask;
  return std::bit_cast<T>(static_cast<Bits>(from_yes | from_no));
}

}  // namespace nlo
