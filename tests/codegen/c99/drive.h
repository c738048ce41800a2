// SPDX-License-Identifier: MIT
// Drives one exported C99 observer: its golden replay, then a long run with random events, whose hash must be the same
// on each target. Include it once for each observer, after
//   #define NLO_NAME rig
//   #define NLO_SCALAR float
//   #define NLO_INPUTS 2  // if it reads inputs
//   #define NLO_SETTLES   // if it can start at a steady state
//   #define NLO_WATCHED   // if it has a monitor
//   #define NLO_SETTLES_BY_Y  // if the steady state depends on its outputs alone
// There are NLO_STEPS steps, and the first NLO_CALM are as in flight; they default to 20000 and 4000.
// It defines `int rig_drive(void)`, which prints "rig HASH" and returns 0, or prints where the replay failed.
// Measurements are made from integers and powers of two, so that nothing rounds, even if the compiler fuses operations.

#ifndef NLO_C99_DRIVE_H
#define NLO_C99_DRIVE_H
#include <stdint.h>

#ifndef NLO_STEPS
#define NLO_STEPS 20000
#define NLO_CALM 4000
#endif

#if defined(NLO_ON_BOARD)
#include "toolchains/semihosting.h"
static void put(const char* text) {
  board_write(text);
}
#else
#include <stdio.h>
static void put(const char* text) {
  fputs(text, stdout);
}
#endif

static void put_hex(uint64_t value) {
  char text[17];
  for (int i = 0; i < 16; ++i) text[i] = "0123456789abcdef"[(value >> (60 - 4 * i)) & 15U];
  text[16] = '\0';
  put(text);
}

// Steps a linear congruential generator. Only its upper bits are used.
static uint32_t next_random(uint32_t* state) {
  return *state = *state * 1664525U + 1013904223U;
}

// Adds bytes to an FNV-1a hash.
static void hash_bytes(uint64_t* hash, const void* bytes, unsigned count) {
  for (unsigned i = 0; i < count; ++i) *hash = (*hash ^ ((const unsigned char*)bytes)[i]) * 0x100000001b3U;
}

#define NLO_JOIN_(a, b) a##b
#define NLO_JOIN(a, b) NLO_JOIN_(a, b)
#define NLO_(word) NLO_JOIN(NLO_NAME, _##word)
#define NLO_TEXT_(a) #a
#define NLO_TEXT(a) NLO_TEXT_(a)
#endif

// Returns a slow triangle of +-4 with a little noise, and sometimes arbitrary bits.
static NLO_SCALAR NLO_(measurement)(uint32_t* random, int k, bool hostile) {
  const uint32_t draw = next_random(random);
  if (hostile && draw >> 31 != 0) {
    union {
      uint32_t words[sizeof(NLO_SCALAR) / 4];
      NLO_SCALAR value;
    } any;
    for (unsigned i = 0; i < sizeof(NLO_SCALAR) / 4; ++i) {
      const uint32_t word = next_random(random);
      any.words[i] = word ^ word >> 16;
    }
    return any.value;
  }
  const int32_t phase = (int32_t)k * 331 % 131072;  // sixteenths of 2^-13
  const int32_t triangle = (phase < 65536 ? phase : 131071 - phase) - 32768;
  return (NLO_SCALAR)(triangle * 8 + (int32_t)(draw >> 19)) / (NLO_SCALAR)65536;
}

#ifdef NLO_INPUTS
#define NLO_INPUT_DRAW      \
  NLO_SCALAR u[NLO_INPUTS]; \
  for (int i = 0; i < NLO_INPUTS; ++i) u[i] = NLO_(measurement)(random, k, k >= NLO_CALM);
#define NLO_AND_U , u
#else
#define NLO_INPUT_DRAW
#define NLO_AND_U
#endif

#if defined(NLO_SETTLES_BY_Y)
#define NLO_START NLO_(warm_start)(o, y)
#elif defined(NLO_SETTLES)
#define NLO_START NLO_(warm_start)(o, y NLO_AND_U)
#else
#define NLO_START NLO_(step)(o, y NLO_AND_U)
#endif

#ifdef NLO_WATCHED
#define NLO_MONITOR , NLO_(monitor) * monitor
#define NLO_AND_MONITOR , &monitor
#define NLO_TRUST                                                                          \
  if (k / 64 % 8 == 5) y[0] = (NLO_SCALAR)1 / (NLO_SCALAR)4; /* a sensor that is frozen */ \
  NLO_(usable_outputs)(monitor, o, y, y);
#else
#define NLO_MONITOR
#define NLO_AND_MONITOR
#define NLO_TRUST
#endif

// Takes a step with one of the many events that an observer may meet.
static NLO_(status) NLO_(happening)(NLO_(observer) * o, NLO_(observer) * saved, uint32_t* random, int k NLO_MONITOR) {
  NLO_SCALAR y[NLO_(NY)];
  for (int j = 0; j < NLO_(NY); ++j) y[j] = NLO_(measurement)(random, k, k >= NLO_CALM);
  NLO_INPUT_DRAW
  NLO_TRUST
  const uint32_t draw = next_random(random);
  const NLO_SCALAR part = (NLO_SCALAR)(int32_t)(draw >> 8 & 0xfffffU) / (NLO_SCALAR)1048576;  // [0, 1)
  switch (k < NLO_CALM ? 15U : draw >> 28) {
    case 0:
      return NLO_(step_dt)(o, y NLO_AND_U, part / (NLO_SCALAR)16);
    case 1:
      return NLO_(step_dt)(o, y NLO_AND_U, NLO_(measurement)(random, k, true));
    case 2:
      return NLO_(step_dt)(o, y NLO_AND_U, part * (NLO_SCALAR)16);  // hundreds of sample periods, or too many
    case 3:
      return NLO_(step_missed)(o NLO_AND_U);
    case 4:
      return k % 7 == 0 ? NLO_START : NLO_(step)(o, y NLO_AND_U);
    case 5:
      if (k % 11 == 0) NLO_(reset)(o);
      return NLO_(step)(o, y NLO_AND_U);
    case 6:
      if (k % 5 == 0) *saved = *o;
      if (k % 5 == 1 && !NLO_(restore)(o, saved)) return NLO_(REJECTED);
      return NLO_(step)(o, y NLO_AND_U);
    case 7: {  // a flip of the highest bit of an exponent
      const uint32_t latent = (draw & 0xffffU) % (uint32_t)(sizeof(o->z) / sizeof(o->z[0]));
      if (k % 3 == 0) ((unsigned char*)&o->z[latent])[sizeof(o->z[0]) - 1] ^= 0x40U;
      return NLO_(step)(o, y NLO_AND_U);
    }
    default:
      return NLO_(step)(o, y NLO_AND_U);
  }
}

static int NLO_(drive)(void) {
  NLO_(observer) o, saved;
  NLO_(init)(&o);
  put(NLO_TEXT(NLO_NAME));
  const int wrong = NLO_(first_mismatch)(&o);
  if (wrong >= 0) {
    put(" answers a sample of its replay wrongly: ");
    put_hex((uint64_t)wrong);
    put("\n");
    return 1;
  }
  NLO_(reset)(&o);
  saved = o;
#ifdef NLO_WATCHED
  NLO_(monitor) monitor, watched;
  unsigned char seen[7] = {0};
  NLO_(monitor_reset)(&monitor);
  watched = monitor;
#endif
  uint32_t random = 1;
  uint64_t hash = 0xcbf29ce484222325U;
  for (int k = 0; k < NLO_STEPS; ++k) {
    const uint32_t word = (uint32_t)NLO_(happening)(&o, &saved, &random, k NLO_AND_MONITOR) +
                          (NLO_(in_domain)(&o) ? 8U : 0U) + 16U * (uint32_t)NLO_(last_status)(&o);
    hash_bytes(&hash, &word, sizeof(word));
    hash_bytes(&hash, o.health, sizeof(o.health));
    for (int j = -1; j <= (int)(sizeof(o.health) / sizeof(o.health[0])); ++j) {
      const unsigned char status = (unsigned char)NLO_(status_of)(&o, j);
      hash_bytes(&hash, &status, 1);
    }
    hash_bytes(&hash, o.z, sizeof(o.z));
    hash_bytes(&hash, o.y, sizeof(o.y));
    NLO_SCALAR x_hat[NLO_(NX)];
#ifdef NLO_WATCHED
    NLO_(estimate)(&o, x_hat);
    const unsigned char alarm = (unsigned char)NLO_(watch)(&monitor, &o, x_hat);
    const bool armed = NLO_(monitor_armed)(&monitor);
    seen[alarm] = 1;
    hash_bytes(&hash, &alarm, 1);
    hash_bytes(&hash, &armed, sizeof(armed));
    hash_bytes(&hash, &monitor.level, sizeof(monitor.level));
    if (k % 3001 == 3000) ((unsigned char*)&monitor.outputs[0].windows[1].power)[sizeof(NLO_SCALAR) - 1] ^= 0x40U;
    if (k % 1009 == 0) watched = monitor;
    if (k % 1009 == 500) hash_bytes(&hash, (unsigned char[]){NLO_(monitor_restore)(&monitor, &watched)}, 1);
#endif
    if (k % 50 != 0) continue;
    NLO_(estimate)(&o, x_hat);
    hash_bytes(&hash, x_hat, sizeof(x_hat));
  }
#ifdef NLO_WATCHED
  for (int i = 0; i < 7; ++i) put(seen[i] ? " +" : " -");
#endif
  put(" ");
  put_hex(hash);
  put("\n");
  return 0;
}
#undef NLO_NAME
#undef NLO_SCALAR
#undef NLO_INPUTS
#undef NLO_SETTLES
#undef NLO_SETTLES_BY_Y
#undef NLO_WATCHED
#undef NLO_MONITOR
#undef NLO_AND_MONITOR
#undef NLO_TRUST
#undef NLO_START
#undef NLO_INPUT_DRAW
#undef NLO_AND_U
