// SPDX-License-Identifier: MIT
#pragma once

#include <type_traits>

#include "nlo/kernels/arithmetic.h"

namespace nlo::trainer {

/// Calls part(size, first) for parts of [0, count) whose sizes differ by at most one. Each size is at most kMost and
/// known at compile time.
template <int kMost, class Part>
NLO_INLINE void in_even_parts(int count, const Part& part) {
  const auto call = [&]<int kSize>(const auto& self, std::integral_constant<int, kSize> most, int size, int first)
                        NLO_INLINE_LAMBDA -> void {
    if constexpr (kSize > 1) {
      if (size < kSize) return self(self, std::integral_constant<int, kSize - 1>(), size, first);
    }
    part(most, first);
  };
  const int parts = (count + kMost - 1) / kMost, least = parts > 0 ? count / parts : 0;
  const int larger = count - parts * least;  // number of parts that have one more
  for (int p = 0, first = 0; p < parts; ++p) {
    const int size = p < larger ? least + 1 : least;
    call(call, std::integral_constant<int, kMost>(), size, first);
    first += size;
  }
}

}  // namespace nlo::trainer
