// SPDX-License-Identifier: MIT
// Golden readings instead of those of the user.
#pragma once

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAMED(word) JOIN(NLO_NAME, _##word)

inline int replayed = 0;
#ifdef NLO_DRIVEN
static inline void NAMED(readings)(NLO_SCALAR* y, NLO_SCALAR* u, NLO_SCALAR missing) {
  for (int j = 0; j < NAMED(NU); ++j) u[j] = NAMED(replay_samples)[replayed].u[j];
#else
static inline void NAMED(readings)(NLO_SCALAR* y, NLO_SCALAR missing) {
#endif
  for (int j = 0; j < NAMED(NY); ++j) {
    const NLO_SCALAR given = NAMED(replay_samples)[replayed].y[j];
    y[j] = given == given ? given : missing;
  }
}
