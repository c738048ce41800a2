// SPDX-License-Identifier: MIT
// An importer of FMI 3.0: the functions of a library, the facts of modelDescription.xml, a log; and steps of an FMU
// and of the C99 pair that must give the same bits. load_fmu.c includes it and lists the macros to define.
#pragma once

#include <dlfcn.h>
#include <math.h>
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
// The function of that name in the library, of the type that the header gives it.
#define F(name) ((__typeof__(&name))symbol(#name))
static void* symbol(const char* name) {
  void* found = dlsym(library, name);
  if (found == NULL) printf("FAILED  the library has no %s\n", name), exit(1);
  return found;
}

// Messages to the importer.
static int told[5];
static char last_message[256], last_category[64];
static void note(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
  EXPECT(environment == told);
  ++told[status];
  snprintf(last_message, sizeof last_message, "%s", message);
  snprintf(last_category, sizeof last_category, "%s", category);
}
static int errors_told(void) {
  const int errors = told[fmi3Error];
  told[fmi3Error] = 0;
  return errors;
}
// A wrong call is answered with an error, and tells one.
#define REFUSED(call) EXPECT((call) == fmi3Error && errors_told() == 1)

static char description[1 << 20];
static void attribute(const char* before, const char* name, char* value, size_t size) {
  const char* at = strstr(description, before);
  EXPECT(at != NULL && (at = strstr(at, name)) != NULL);
  at += strlen(name) + 2;
  snprintf(value, size, "%.*s", (int)(strchr(at, '"') - at), at);
}
static fmi3ValueReference reference_of(const char* name) {
  char start[80], value[80];
  snprintf(start, sizeof start, "name=\"%s", name);
  attribute(start, "valueReference", value, sizeof value);
  return (fmi3ValueReference)atoi(value);
}

static char token[80];
static fmi3ValueReference measured, input, estimate, status_reference, domain, latent, initial;

static fmi3Instance instance_named(const char* name, const char* with_token, bool logging, bool event_mode) {
  return F(fmi3InstantiateCoSimulation)(name, with_token, NULL, false, logging, event_mode, false, NULL, 0, told, note,
                                        NULL);
}
static fmi3Instance begun(double start) {
  fmi3Instance i = instance_named("observer", token, false, false);
  EXPECT(i != NULL);
  EXPECT(F(fmi3EnterInitializationMode)(i, false, 0, start, false, 0) == fmi3OK);
  EXPECT(F(fmi3ExitInitializationMode)(i) == fmi3OK);
  return i;
}

static fmi3Status do_step(fmi3Instance i, double* time, double step) {
  fmi3Boolean event = true, terminate = true, early = true;
  double last = -1;
  const fmi3Status status = F(fmi3DoStep)(i, *time, step, true, &event, &terminate, &early, &last);
  if (status <= fmi3Warning) {
    EXPECT(!event && !terminate && !early && last == *time + step);
    *time = last;
  }
  return status;
}

// The C99 pair, and its monitor where there is one.
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

// A step of both over sample `k`, or with its readings halved; and all that can be read is the same.
static void step_both(fmi3Instance i, double* time, Pair* pair, int k, bool halved) {
  Observer* observer = &pair->observer;
  const NAMED(replay_sample) sample = NAMED(replay_samples)[k];
  Scalar y[kNy], u[kNu + 1] = {0};
  double given[kNy + kNu];
  fmi3ValueReference references[kNy + kNu];
  for (int j = 0; j < kNy; ++j) given[j] = (double)(y[j] = halved ? sample.y[j] / 2 : sample.y[j]);
#ifdef NLO_DRIVEN
  for (int j = 0; j < kNu; ++j) given[kNy + j] = (double)(u[j] = halved ? -sample.u[j] : sample.u[j]);
#define AND_U , u
#else
#define AND_U
  (void)u;
#endif
  for (int j = 0; j < kNy + kNu; ++j) references[j] = j < kNy ? measured + (unsigned)j : input + (unsigned)(j - kNy);
  EXPECT(F(fmi3SetFloat64)(i, references, kNy + kNu, given, kNy + kNu) == fmi3OK);
  char period[40];
  attribute("<DefaultExperiment", "stepSize", period, sizeof period);
  const bool regular = !(sample.dt_s > 0);
  const fmi3Status answer = do_step(i, time, regular ? atof(period) : (double)sample.dt_s);
#ifdef NLO_MONITORED
  NAMED(usable_outputs_dt)(&pair->monitor, observer, y, regular ? 0 : sample.dt_s, y);
#endif
  const NAMED(status) want = regular ? NAMED(step)(observer, y AND_U) : NAMED(step_dt)(observer, y AND_U, sample.dt_s);
  Scalar x_hat[kNx];
  NAMED(estimate)(observer, x_hat);
#ifdef NLO_MONITORED
  const fmi3ValueReference alarm_reference = reference_of("alarm\"");
  const NAMED(alarm) alarm = NAMED(watch)(&pair->monitor, observer, x_hat);
  fmi3Int64 told_alarm;
  EXPECT(F(fmi3GetInt64)(i, &alarm_reference, 1, &told_alarm, 1) == fmi3OK && told_alarm == (int)alarm);
  const bool well = alarm == NAMED(NO_ALARM) && want == NAMED(OK);
#else
  if (!halved) EXPECT(want == sample.status);
  const bool well = want == NAMED(OK);
#endif
  EXPECT(answer == (well ? fmi3OK : fmi3Warning));

  double got[kNx + kNz];
  fmi3ValueReference wanted[kNx + 1];
  for (int n = 0; n < kNx; ++n) wanted[n] = estimate + (unsigned)n;
  wanted[kNx] = latent;
  EXPECT(F(fmi3GetFloat64)(i, wanted, kNx + 1, got, kNx + kNz) == fmi3OK);
  for (int n = 0; n < kNx + kNz; ++n) {
    const double number = (double)(n < kNx ? x_hat[n] : observer->z[n - kNx]);
    EXPECT(memcmp(&got[n], &number, sizeof number) == 0);
  }
  fmi3Int64 status;
  fmi3Boolean inside;
  EXPECT(F(fmi3GetInt64)(i, &status_reference, 1, &status, 1) == fmi3OK && status == (int)want);
  EXPECT(F(fmi3GetBoolean)(i, &domain, 1, &inside, 1) == fmi3OK && inside == NAMED(in_domain)(observer));
}
