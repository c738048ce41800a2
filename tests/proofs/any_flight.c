// SPDX-License-Identifier: MIT
// The program that Frama-C's EVA analyses (eva.sh) with an exported C99 pair NAME: any sequence of calls with any
// arguments, including NaN and infinities; then each call on an observer with any bits in its memory.
#include <__fc_builtin.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAME_(word) JOIN(NAME, _##word)

extern volatile int any_int;
extern volatile SCALAR any_scalar;

#ifdef INPUTS
#define AND_U , u
#else
#define AND_U
#endif

static void any_call(NAME_(observer) * o, int which) {
  SCALAR y[NAME_(NY)];
  for (int j = 0; j < NAME_(NY); ++j) y[j] = any_scalar;
#ifdef INPUTS
  SCALAR u[INPUTS];
  for (int i = 0; i < INPUTS; ++i) u[i] = any_scalar;
#endif
  switch (which) {
    case 0:
      NAME_(step_dt)(o, y AND_U, any_scalar);
      break;
    case 1:
      NAME_(step_missed)(o AND_U);
      break;
    case 2:
      NAME_(reset)(o);
      break;
#ifdef SETTLES
    case 3:
#ifdef SETTLES_BY_Y
      NAME_(warm_start)(o, y);
#else
      NAME_(warm_start)(o, y AND_U);
#endif
      break;
#endif
    default:
      NAME_(step)(o, y AND_U);
      break;
  }
}

static void any_question(const NAME_(observer) * o) {
  NAME_(last_status)(o);
  NAME_(status_of)(o, any_int);
  NAME_(in_domain)(o);
#ifdef STALENESS
  NAME_(staleness)(o, any_int);
#endif
}

static void estimate(const NAME_(observer) * o) {
  SCALAR x_hat[NAME_(NX)];
  NAME_(estimate)(o, x_hat);
#ifndef UNIT_LENGTH
  for (int i = 0; i < NAME_(NX); ++i) {
    //@ assert estimate: \is_finite(x_hat[i]);
  }
#endif
}

#ifdef WATCHED
static void any_watch(NAME_(monitor) * m, const NAME_(observer) * o) {
  SCALAR y[NAME_(NY)], x_hat[NAME_(NX)];
  for (int j = 0; j < NAME_(NY); ++j) y[j] = any_scalar;
  NAME_(usable_outputs)(m, o, y, y);
  NAME_(estimate)(o, x_hat);
  NAME_(watch)(m, o, x_hat);
  NAME_(monitor_armed)(m);
  //@ assert alarm: m->alarm <= NAME_(MONITOR_RESET);
}
#endif

int main(void) {
  static const SCALAR turns[] = TURNS;
  NAME_(observer) o, saved;
  NAME_(init)(&o);
#ifdef WATCHED
  NAME_(monitor) monitor, saved_monitor;
  NAME_(monitor_reset)(&monitor);
#endif
  while (any_int) {
    any_question(&o);
    estimate(&o);
#ifdef WATCHED
    if (any_int) Frama_C_make_unknown((char*)&monitor, sizeof monitor);
    any_watch(&monitor, &o);
    if (any_int) {
      Frama_C_make_unknown((char*)&saved_monitor, sizeof saved_monitor);
      NAME_(monitor_restore)(&monitor, &saved_monitor);
    }
#endif
    if (any_int) {
      any_call(&o, any_int);
    } else {
      Frama_C_make_unknown((char*)&saved, sizeof saved);
      NAME_(restore)(&o, &saved);
    }
    for (int j = 0; j < (int)(sizeof(o.y) / sizeof(o.y[0])); ++j) {
      // EVA does not track relations between numbers; gappa.py proves that an angle stays within its turn.
      if (turns[j] > 0) {
        //@ admit angle: \is_finite(o.y[j]) && -turns[j] <= o.y[j] <= turns[j];
      }
      //@ assert reading: \is_finite(o.y[j]);
    }
    for (int r = 0; r < NAME_(NZ); ++r) {
      //@ assert latent: \is_finite(o.z[r]) && -LARGEST < o.z[r] < LARGEST;
    }
  }
  // Flipped bits: no undefined behaviour, and z is finite after one step.
  Frama_C_make_unknown((char*)&o, sizeof o);
  any_question(&o);
  any_call(&o, any_int);
  Frama_C_make_unknown((char*)&o, sizeof o);
  any_call(&o, 4);
  for (int r = 0; r < NAME_(NZ); ++r) {
    //@ assert healed: \is_finite(o.z[r]) && -LARGEST < o.z[r] < LARGEST;
  }
  return 0;
}
