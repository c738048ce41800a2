// SPDX-License-Identifier: MIT
// Results of networks for one instruction set, to be compared bit for bit. Plain numbers, because files that include
// this are compiled for different CPUs and must not share an inline function.
#pragma once

namespace instruction_set {

inline constexpr int kRounds = 20, kPlants = 37, kUnits = 32;
inline constexpr int kWholeBlocks = 32;  ///< number of plants that fills whole blocks, so none is stepped alone

struct Bits {
  float estimate[kRounds][2], jvp[kRounds][2], batch[2][kPlants], silu_jvp[kRounds][2];
  float log2_sigma[kRounds][2], gated[kRounds][kUnits];
  float latent[3][kWholeBlocks];  ///< after kRounds samples
};

/// Results of code that the compiler generated for one instruction set.
Bits bits_of_baseline();  ///< any x86-64: SSE2
Bits bits_of_avx2();      ///< AVX2 with FMA
Bits bits_of_avx512();
Bits bits_of_avx512_one_load();  ///< AVX-512, tuned for CPUs that load 64 bytes once a cycle

}  // namespace instruction_set
