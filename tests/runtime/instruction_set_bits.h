// SPDX-License-Identifier: MIT
// Results of networks of one instruction set, to compare bit for bit. Plain numbers, because files that include this
// are compiled for different CPUs and must not share an inline function.
#pragma once

namespace instruction_set {

inline constexpr int kRounds = 20, kPlants = 37, kUnits = 32;
inline constexpr int kWholeBlocks = 32;  ///< plants of which none is stepped by itself

struct Bits {
  float estimate[kRounds][2], jvp[kRounds][2], batch[2][kPlants], silu_jvp[kRounds][2];
  float log2_sigma[kRounds][2], gated[kRounds][kUnits];
  float latent[3][kWholeBlocks];  ///< kRounds samples on
};

/// Computed by code that the compiler made for one instruction set.
Bits bits_of_baseline();  ///< any x86-64: SSE2
Bits bits_of_avx2();      ///< AVX2 with FMA
Bits bits_of_avx512();
Bits bits_of_avx512_one_load();  ///< AVX-512, tuned for CPUs that load 64 bytes once a cycle

}  // namespace instruction_set
