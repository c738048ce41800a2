// SPDX-License-Identifier: MIT
// What networks of one instruction set compute, to compare bit for bit. Plain numbers: files that include this are
// compiled for different CPUs, and share no inline function.
#pragma once

namespace instruction_set {

inline constexpr int kRounds = 20, kPlants = 37, kUnits = 32;
inline constexpr int kWholeBlocks = 32;  ///< plants of which none is stepped by itself

struct Bits {
  float estimate[kRounds][2], jvp[kRounds][2], batch[2][kPlants], silu_jvp[kRounds][2];
  float log2_sigma[kRounds][2], gated[kRounds][kUnits];
  float latent[3][kWholeBlocks];  ///< kRounds samples on
};

/// Of the compiler's own instruction set, told of AVX2 with FMA or of AVX-512.
Bits bits_of_avx2();
Bits bits_of_avx512();

}  // namespace instruction_set
