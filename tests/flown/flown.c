// SPDX-License-Identifier: MIT
// Flies an export to C99.
#include <flown.h>

#include <math.h>

static flown_observer observer;
static flown_monitor monitor;

int flown_sizes(int* sizes) {
  sizes[0] = FLOWN_MEASURED;
  sizes[1] = FLOWN_INPUTS;
  sizes[2] = FLOWN_STATES;
  return 0;
}

void flown_start(void) {
  flown_init(&observer);
  flown_monitor_reset(&monitor);
}

int flown_sample(const float* y, const float* u, float dt_s, int gated, float* x_hat) {
  float kept[FLOWN_MEASURED];
  int rejected = 0;
  for (int j = 0; j < FLOWN_MEASURED; ++j) kept[j] = y[j];
  if (gated != 0) flown_usable_outputs_dt(&monitor, &observer, y, dt_s, kept);
#if FLOWN_INPUTS > 0
  const flown_status status = (dt_s == 0.0F) ? flown_step(&observer, kept, u) : flown_step_dt(&observer, kept, u, dt_s);
#else
  (void)u;
  const flown_status status = (dt_s == 0.0F) ? flown_step(&observer, kept) : flown_step_dt(&observer, kept, dt_s);
#endif
  flown_estimate(&observer, x_hat);
  const flown_alarm alarm = flown_watch(&monitor, &observer, x_hat);
  for (int j = 0; j < FLOWN_MEASURED; ++j) rejected |= isfinite(y[j]) && !(kept[j] == y[j]);
  return (status >= flown_STALE ? 1 : 0) | (flown_in_domain(&observer) ? 0 : 2) | (alarm != flown_NO_ALARM ? 4 : 0) |
         (rejected ? 8 : 0) | (flown_monitor_armed(&monitor) ? 16 : 0) | (int)alarm << 5;
}
