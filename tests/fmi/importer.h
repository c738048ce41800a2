// SPDX-License-Identifier: MIT
// The parts of an importer that do not depend on the version of FMI: the functions of a library, the values in
// modelDescription.xml, and the C99 pair, whose bits an FMU must reproduce. load_fmu.c lists the macros to define.
#pragma once

#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAMED(word) JOIN(NLO_NAME, _##word)

typedef NLO_SCALAR Scalar;
typedef NAMED(observer) Observer;
enum {
  kNx = NAMED(NX),
  kNy = NAMED(NY),
  kNz = NAMED(NZ),
  kSamples = sizeof(NAMED(replay_samples)) / sizeof(NAMED(replay_samples)[0])
};
#ifdef NLO_DRIVEN
enum { kNu = NAMED(NU) };
#else
enum { kNu = 0 };
#endif

#define EXPECT(condition)                                    \
  do {                                                       \
    if (!(condition)) {                                      \
      printf("FAILED  line %d: %s\n", __LINE__, #condition); \
      exit(1);                                               \
    }                                                        \
  } while (0)

static void* library;
// Returns the function of this name in the library, with the type that the header declares.
#define F(name) ((__typeof__(&name))symbol(#name))
static void* symbol(const char* name) {
  void* found = dlsym(library, name);
  if (found == NULL) printf("FAILED  the library has no %s\n", name), exit(1);
  return found;
}

static char description[1 << 20];
static void attribute(const char* before, const char* name, char* value, size_t size) {
  const char* at = strstr(description, before);
  EXPECT(at != NULL && (at = strstr(at, name)) != NULL);
  at += strlen(name) + 2;
  snprintf(value, size, "%.*s", (int)(strchr(at, '"') - at), at);
}
static unsigned reference_of(const char* name) {
  char start[80], value[80];
  snprintf(start, sizeof start, "name=\"%s", name);
  attribute(start, "valueReference", value, sizeof value);
  return (unsigned)atoi(value);
}

// The C99 pair and, if it has one, its monitor.
typedef struct {
  Observer observer;
#ifdef NLO_MONITORED
  NAMED(monitor) monitor;
#endif
} Pair;
static void begin(Pair* pair) {
  NAMED(init)(&pair->observer);
#ifdef NLO_MONITORED
  NAMED(monitor_reset)(&pair->monitor);
#endif
}

// Result of a step of the pair over one sample of the replay.
typedef struct {
  double given[kNy + kNu];  // measurements, then inputs
  double period;            // [s]
  Scalar x_hat[kNx];
  NAMED(status) status;
  int alarm;   // 0 without a monitor
  bool is_ok;  // whether an FMU returns OK; otherwise it returns a warning
} PairStep;
static PairStep step_pair(Pair* pair, int k, bool halved) {
  PairStep step;
  const NAMED(replay_sample) sample = NAMED(replay_samples)[k];
  Scalar y[kNy], u[kNu + 1] = {0};
  for (int j = 0; j < kNy; ++j) step.given[j] = (double)(y[j] = halved ? sample.y[j] / 2 : sample.y[j]);
#ifdef NLO_DRIVEN
  for (int j = 0; j < kNu; ++j) step.given[kNy + j] = (double)(u[j] = halved ? -sample.u[j] : sample.u[j]);
#define AND_U , u
#else
#define AND_U
  (void)u;
#endif
  char period[40];
  attribute("<DefaultExperiment", "stepSize", period, sizeof period);
  const bool regular = !(sample.dt_s > 0);
  step.period = regular ? atof(period) : (double)sample.dt_s;
  Observer* observer = &pair->observer;
#ifdef NLO_MONITORED
  NAMED(usable_outputs_dt)(&pair->monitor, observer, y, regular ? 0 : sample.dt_s, y);
#endif
  step.status = regular ? NAMED(step)(observer, y AND_U) : NAMED(step_dt)(observer, y AND_U, sample.dt_s);
  NAMED(estimate)(observer, step.x_hat);
  step.is_ok = step.status == NAMED(OK);
  step.alarm = 0;
#ifdef NLO_MONITORED
  step.alarm = (int)NAMED(watch)(&pair->monitor, observer, step.x_hat);
  step.is_ok = step.is_ok && step.alarm == (int)NAMED(NO_ALARM);
#else
  if (!halved) EXPECT(step.status == sample.status);
#endif
  return step;
}

static void open_library(int argc, char** argv) {
  EXPECT(argc == 3);
  FILE* file = fopen(argv[2], "r");
  EXPECT(file != NULL && fread(description, 1, sizeof description - 1, file) > 0);
  fclose(file);
  library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) printf("FAILED  %s\n", dlerror()), exit(1);
}
