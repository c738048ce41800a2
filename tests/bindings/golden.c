/* SPDX-License-Identifier: MIT
 * Golden inputs of `nlo export --target replay-c99` through libnlo-model: the generated header is given these functions
 * instead of the exported observer, so it compares the interface with the golden results of firmware.
 * GOLDEN_... are sizes and names of a model, with GOLDEN_NU 0 if it has no inputs; see installed.sh.
 * usage: golden MODEL.json
 */
#include <nlo_model.h>
#include <stdbool.h>
#include <stdio.h>

#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)
#define NAMED(b) JOIN(GOLDEN_NAME, b)

typedef enum {
  NAMED(_OK),
  NAMED(_CLAMPED),
  NAMED(_HELD),
  NAMED(_STALE),
  NAMED(_OUT_OF_RANGE),
  NAMED(_REJECTED),
  NAMED(_DIVERGED)
} NAMED(_status);

typedef struct {
  nlo_observer* through;
  float z[GOLDEN_NZ];
} NAMED(_observer);

static NAMED(_status) stepped(NAMED(_observer) * observer, const float* y, const float* u, float dt_s) {
  double wide[GOLDEN_NY + GOLDEN_NU], z[GOLDEN_NZ];
  int j, status;
  for (j = 0; j < GOLDEN_NY; ++j) wide[j] = (double)y[j];
  for (j = 0; j < GOLDEN_NU; ++j) wide[GOLDEN_NY + j] = (double)u[j];
  status = dt_s == 0.0f ? nlo_observer_step(observer->through, wide, wide + GOLDEN_NY)
                        : nlo_observer_step_dt(observer->through, wide, wide + GOLDEN_NY, (double)dt_s);
  nlo_observer_latent(observer->through, z);
  for (j = 0; j < GOLDEN_NZ; ++j) observer->z[j] = (float)z[j];
  return (NAMED(_status))status;
}
#if GOLDEN_NU > 0
static NAMED(_status) NAMED(_step_dt)(NAMED(_observer) * observer, const float* y, const float* u, float dt_s) {
  return stepped(observer, y, u, dt_s);
}
static NAMED(_status) NAMED(_step)(NAMED(_observer) * observer, const float* y, const float* u) {
  return stepped(observer, y, u, 0.0f);
}
#else
static NAMED(_status) NAMED(_step_dt)(NAMED(_observer) * observer, const float* y, float dt_s) {
  return stepped(observer, y, NULL, dt_s);
}
static NAMED(_status) NAMED(_step)(NAMED(_observer) * observer, const float* y) {
  return stepped(observer, y, NULL, 0.0f);
}
#endif
static NAMED(_status) NAMED(_last_status)(const NAMED(_observer) * observer) {
  return (NAMED(_status))nlo_observer_status(observer->through);
}
static void NAMED(_estimate)(const NAMED(_observer) * observer, float* x_hat) {
  double wide[GOLDEN_NX];
  int i;
  nlo_observer_estimate(observer->through, wide);
  for (i = 0; i < GOLDEN_NX; ++i) x_hat[i] = (float)wide[i];
}

#include GOLDEN_REPLAY

int main(int argc, char** argv) {
  nlo_model* model = argc == 2 ? nlo_model_from_file(argv[1]) : NULL;
  NAMED(_observer) observer;
  int wrong;
  observer.through = nlo_observer_create(model, NLO_DOUBLE);
  if (observer.through == NULL) {
    fprintf(stderr, "%s\n", nlo_last_error());
    return 2;
  }
  wrong = NAMED(_first_mismatch)(&observer);
  if (wrong >= 0) printf("sample %d differs\n", wrong);
  nlo_observer_free(observer.through);
  nlo_model_free(model);
  return wrong >= 0;
}
