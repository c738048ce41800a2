// SPDX-License-Identifier: MIT
// The two ways in which an observer may round. A template parameter of the observer chooses:
//   nlo::KklObserver<Model, nlo::Arithmetic::kDeterministic> observer{kModel};
#pragma once

#include <cstdint>

#include "nlo/cxx20.h"

namespace nlo {

enum class Arithmetic : std::uint8_t {
  kFast,           ///< sums in the order that suits the target, fused multiply-adds where it has them
  kDeterministic,  ///< one order, each operation rounded by itself: the same bits on every IEEE 754 target, compiler
                   ///< and optimisation level (but not with -ffast-math)
};

}  // namespace nlo
