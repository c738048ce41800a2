// SPDX-License-Identifier: MIT
// An importer of FMI 3.0 for one FMU: it loads the library, uses only what modelDescription.xml declares, and calls all
// functions, also with wrong arguments. Results must have the bits of the C99 pair. Compile it with NLO_NAME,
// NLO_SCALAR, NLO_DRIVEN if there are inputs, NLO_MONITORED if there is a monitor, and the headers of FMU and
// replay-c99.
//   load_fmu LIBRARY modelDescription.xml
#include "tests/fmi/importer.h"

// Messages to the importer.
static int logged[5];
static char last_message[256], last_category[64];
static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message) {
  EXPECT(environment == logged);
  ++logged[status];
  snprintf(last_message, sizeof last_message, "%s", message);
  snprintf(last_category, sizeof last_category, "%s", category);
}
static int errors_logged(void) {
  const int errors = logged[fmi3Error];
  logged[fmi3Error] = 0;
  return errors;
}
// A wrong call must return an error and log exactly one message.
#define REFUSED(call) EXPECT((call) == fmi3Error && errors_logged() == 1)

static char token[80];
static fmi3ValueReference measured, input, estimate, status_reference, domain, latent, initial;

static fmi3Instance instance_named(const char* name, const char* with_token, bool logging, bool event_mode) {
  return F(fmi3InstantiateCoSimulation)(name, with_token, NULL, false, logging, event_mode, false, NULL, 0, logged,
                                        log_message, NULL);
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

// Steps the FMU and the pair over sample `k`, optionally with halved readings, and compares all variables.
static void step_both(fmi3Instance i, double* time, Pair* pair, int k, bool halved) {
  const PairStep want = step_pair(pair, k, halved);
  fmi3ValueReference references[kNy + kNu];
  for (int j = 0; j < kNy + kNu; ++j) references[j] = j < kNy ? measured + (unsigned)j : input + (unsigned)(j - kNy);
  EXPECT(F(fmi3SetFloat64)(i, references, kNy + kNu, want.given, kNy + kNu) == fmi3OK);
  EXPECT(do_step(i, time, want.period) == (want.is_ok ? fmi3OK : fmi3Warning));
#ifdef NLO_MONITORED
  const fmi3ValueReference alarm_reference = reference_of("alarm\"");
  fmi3Int64 alarm;
  EXPECT(F(fmi3GetInt64)(i, &alarm_reference, 1, &alarm, 1) == fmi3OK && alarm == want.alarm);
#endif

  double got[kNx + kNz];
  fmi3ValueReference wanted[kNx + 1];
  for (int n = 0; n < kNx; ++n) wanted[n] = estimate + (unsigned)n;
  wanted[kNx] = latent;
  EXPECT(F(fmi3GetFloat64)(i, wanted, kNx + 1, got, kNx + kNz) == fmi3OK);
  for (int n = 0; n < kNx + kNz; ++n) {
    const double number = (double)(n < kNx ? want.x_hat[n] : pair->observer.z[n - kNx]);
    EXPECT(memcmp(&got[n], &number, sizeof number) == 0);
  }
  fmi3Int64 status;
  fmi3Boolean inside;
  EXPECT(F(fmi3GetInt64)(i, &status_reference, 1, &status, 1) == fmi3OK && status == (int)want.status);
  EXPECT(F(fmi3GetBoolean)(i, &domain, 1, &inside, 1) == fmi3OK && inside == NAMED(in_domain)(&pair->observer));
}

static void replays_and_disturbs_no_other(void) {
  double time = 3, other_time = 0;
  fmi3Instance one = begun(time), other = begun(other_time);
  Observer golden;
  Pair pair, other_pair;
  NAMED(init)(&golden);
  EXPECT(NAMED(first_mismatch)(&golden) == -1);
  begin(&pair);
  begin(&other_pair);
  for (int k = 0; k < kSamples; ++k) {
    step_both(one, &time, &pair, k, false);
    step_both(other, &other_time, &other_pair, k, true);
  }
  F(fmi3FreeInstance)(other);
  EXPECT(F(fmi3Reset)(one) == fmi3OK);
  EXPECT(F(fmi3EnterInitializationMode)(one, true, 1e-6, 0, false, 0) == fmi3OK &&
         F(fmi3ExitInitializationMode)(one) == fmi3OK);
  begin(&pair);
  time = 0;
  for (int k = 0; k < kSamples / 2; ++k) step_both(one, &time, &pair, k, false);  // must behave like a new instance
  F(fmi3FreeInstance)(one);
}

static void continues_from_saved_states(void) {
  const int half = kSamples / 2;
  double time = 0;
  fmi3Instance i = begun(time), fresh = instance_named("fresh", token, false, false);
  Pair pair, at_half;
  begin(&pair);
  for (int k = 0; k < half; ++k) step_both(i, &time, &pair, k, false);
  const double time_at_half = time;
  at_half = pair;
  fmi3FMUState state = NULL, loaded = NULL;
  EXPECT(F(fmi3GetFMUState)(i, &state) == fmi3OK && state != NULL);
  fmi3FMUState same = state;
  EXPECT(F(fmi3GetFMUState)(i, &same) == fmi3OK && same == state);  // the memory of the saved state is reused
  size_t size = 0;
  EXPECT(F(fmi3SerializedFMUStateSize)(i, state, &size) == fmi3OK && size > sizeof(Observer));
  fmi3Byte* bytes = malloc(size);
  REFUSED(F(fmi3SerializeFMUState)(i, state, bytes, size - 1));
  REFUSED(F(fmi3SerializeFMUState)(i, state, NULL, size));
  EXPECT(F(fmi3SerializeFMUState)(i, state, bytes, size) == fmi3OK);
  for (int k = half; k < kSamples; ++k) step_both(i, &time, &pair, k, false);

  EXPECT(F(fmi3SetFMUState)(i, state) == fmi3OK);
  EXPECT(F(fmi3FreeFMUState)(i, &state) == fmi3OK && state == NULL && F(fmi3FreeFMUState)(i, &state) == fmi3OK);
  time = time_at_half;
  pair = at_half;
  for (int k = half; k < kSamples; ++k) step_both(i, &time, &pair, k, false);

  EXPECT(F(fmi3DeserializeFMUState)(fresh, bytes, size, &loaded) == fmi3OK);
  EXPECT(F(fmi3SetFMUState)(fresh, loaded) == fmi3OK && F(fmi3FreeFMUState)(fresh, &loaded) == fmi3OK);
  time = time_at_half;
  pair = at_half;
  for (int k = half; k < kSamples; ++k) step_both(fresh, &time, &pair, k, false);

  REFUSED(F(fmi3DeserializeFMUState)(fresh, bytes, size - 1, &loaded));
  REFUSED(F(fmi3DeserializeFMUState)(fresh, NULL, size, &loaded));
  for (size_t n = 0; n < size; ++n) {  // a flip of any bit must be detected
    bytes[n] ^= (fmi3Byte)(1U << n % 8);
    REFUSED(F(fmi3DeserializeFMUState)(fresh, bytes, size, &loaded));
    bytes[n] ^= (fmi3Byte)(1U << n % 8);
  }
  EXPECT(loaded == NULL);
  REFUSED(F(fmi3GetFMUState)(i, NULL));
  REFUSED(F(fmi3SetFMUState)(i, NULL));
  REFUSED(F(fmi3FreeFMUState)(i, NULL));
  REFUSED(F(fmi3SerializedFMUStateSize)(i, NULL, &size));
  free(bytes);
  F(fmi3FreeInstance)(i);
  F(fmi3FreeInstance)(fresh);
}

static void takes_only_its_own_token(void) {
  EXPECT(instance_named("x", "{0}", true, false) == NULL && errors_logged() == 1 &&
         strstr(last_message, token) != NULL);
  EXPECT(instance_named("x", NULL, true, false) == NULL && errors_logged() == 1);
  EXPECT(instance_named(NULL, token, true, false) == NULL && errors_logged() == 1);
  EXPECT(instance_named("x", token, true, true) == NULL && errors_logged() == 1);
  EXPECT(F(fmi3InstantiateCoSimulation)("x", "{0}", NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL) == NULL);  // no logger
  EXPECT(F(fmi3InstantiateModelExchange)("x", token, NULL, false, false, logged, log_message) == NULL &&
         errors_logged() == 1);
  EXPECT(F(fmi3InstantiateScheduledExecution)("x", token, NULL, false, false, logged, log_message, NULL, NULL, NULL) ==
             NULL &&
         errors_logged() == 1);
}

static void refuses_wrong_calls(void) {
  fmi3Instance i = instance_named("observer", token, false, false);
  double time = 0, numbers[kNz + kNx + 2] = {0};
  const fmi3ValueReference wrong[] = {measured, sizeof description, status_reference};
  REFUSED(F(fmi3ExitInitializationMode)(i));
  REFUSED(do_step(i, &time, 0.01));
  REFUSED(F(fmi3Terminate)(i));
  REFUSED(F(fmi3EnterInitializationMode)(i, false, 0, (double)NAN, false, 0));
  REFUSED(F(fmi3EnterInitializationMode)(i, false, 0, 1, true, 0));
  EXPECT(F(fmi3EnterInitializationMode)(i, false, 0, 0, true, 10) == fmi3OK);
  REFUSED(F(fmi3EnterInitializationMode)(i, false, 0, 0, false, 0));

  // The latent state can be set before the first reading: completely, to finite values, and not later.
  Observer observer;
  NAMED(init)(&observer);
  for (int r = 0; r < kNz; ++r) numbers[r] = (double)(observer.z[r] += (Scalar)0.125 * (Scalar)r);
  EXPECT(F(fmi3SetFloat64)(i, &initial, 1, numbers, kNz) == fmi3OK);
  Scalar x_hat[kNx];
  double got[kNz];
  NAMED(estimate)(&observer, x_hat);
  EXPECT(F(fmi3GetFloat64)(i, &estimate, 1, got, 1) == fmi3OK && got[0] == (double)x_hat[0]);
  REFUSED(F(fmi3SetFloat64)(i, &initial, 1, numbers, kNz - 1));
  numbers[kNz - 1] = (double)NAN;
  REFUSED(F(fmi3SetFloat64)(i, &initial, 1, numbers, kNz));
  EXPECT(F(fmi3GetFloat64)(i, &initial, 1, got, kNz) == fmi3OK && got[kNz - 1] == (double)observer.z[kNz - 1]);
  EXPECT(F(fmi3ExitInitializationMode)(i) == fmi3OK);
  REFUSED(F(fmi3SetFloat64)(i, &initial, 1, got, kNz));

  numbers[0] = 0.5;
  EXPECT(F(fmi3SetFloat64)(i, &measured, 1, numbers, 1) == fmi3OK);
  numbers[0] = 0.75;
  for (int k = 1; k < 3; ++k) {  // the first value is valid, but must not be set either
    const fmi3ValueReference pair[] = {measured, wrong[k]};
    REFUSED(F(fmi3SetFloat64)(i, pair, 2, numbers, 2));
    REFUSED(F(fmi3GetFloat64)(i, pair, 2, numbers, 2));
  }
  REFUSED(F(fmi3SetFloat64)(i, &estimate, 1, numbers, 1));
  REFUSED(F(fmi3SetFloat64)(i, &measured, 1, numbers, 2));
  REFUSED(F(fmi3SetFloat64)(i, NULL, 1, numbers, 1));
  REFUSED(F(fmi3GetFloat64)(i, &measured, 1, NULL, 1));
  EXPECT(F(fmi3GetFloat64)(i, &measured, 1, got, 1) == fmi3OK && got[0] == 0.5);
  EXPECT(F(fmi3GetFloat64)(i, NULL, 0, NULL, 0) == fmi3OK && F(fmi3SetFloat64)(i, NULL, 0, NULL, 0) == fmi3OK);
  fmi3Int64 number = 0;
  fmi3Boolean truth = false;
  REFUSED(F(fmi3GetInt64)(i, &domain, 1, &number, 1));
  REFUSED(F(fmi3GetInt64)(i, &status_reference, 1, &number, 2));
  REFUSED(F(fmi3SetInt64)(i, &status_reference, 1, &number, 1));
  REFUSED(F(fmi3GetBoolean)(i, &status_reference, 1, &truth, 1));
  REFUSED(F(fmi3SetBoolean)(i, &domain, 1, &truth, 1));

  for (int k = 0; k < 4; ++k) {
    const double steps[] = {0, -0.01, (double)NAN, HUGE_VAL};
    REFUSED(do_step(i, &time, steps[k]));
  }
  double elsewhere = 1;
  REFUSED(do_step(i, &elsewhere, 0.01));
  REFUSED(do_step(i, &time, 10.1));  // ends after the stop time
  REFUSED(F(fmi3DoStep)(i, time, 0.01, true, NULL, &truth, &truth, numbers));
  EXPECT(F(fmi3GetFloat64)(i, wrong, 1, got, 1) == fmi3OK && got[0] == 0.5);  // the instance still works
  EXPECT(do_step(i, &time, 0.01) <= fmi3Warning && F(fmi3Terminate)(i) == fmi3OK);
  REFUSED(do_step(i, &time, 0.01));
  REFUSED(F(fmi3SetFloat64)(i, &measured, 1, numbers, 1));
  EXPECT(F(fmi3GetFloat64)(i, &estimate, 1, got, 1) == fmi3OK && F(fmi3Reset)(i) == fmi3OK);
  F(fmi3FreeInstance)(i);
  F(fmi3FreeInstance)(NULL);

  EXPECT(F(fmi3Reset)(NULL) == fmi3Error && F(fmi3Terminate)(NULL) == fmi3Error &&
         do_step(NULL, &time, 0.01) == fmi3Error);
  EXPECT(F(fmi3GetFloat64)(NULL, &measured, 1, numbers, 1) == fmi3Error &&
         F(fmi3SetFloat64)(NULL, &measured, 1, numbers, 1) == fmi3Error);
  EXPECT(F(fmi3GetInt64)(NULL, &status_reference, 1, &number, 1) == fmi3Error &&
         F(fmi3SetInt64)(NULL, NULL, 0, NULL, 0) == fmi3Error);
  EXPECT(F(fmi3GetBoolean)(NULL, &domain, 1, &truth, 1) == fmi3Error &&
         F(fmi3SetBoolean)(NULL, NULL, 0, NULL, 0) == fmi3Error);
  EXPECT(F(fmi3SetDebugLogging)(NULL, true, 0, NULL) == fmi3Error && F(fmi3SetFMUState)(NULL, NULL) == fmi3Error);
  EXPECT(F(fmi3EnterInitializationMode)(NULL, 0, 0, 0, 0, 0) == fmi3Error &&
         F(fmi3ExitInitializationMode)(NULL) == fmi3Error);
  EXPECT(errors_logged() == 0);
}

static void tells_what_it_is_asked_to(void) {
  fmi3Instance i = begun(0);
  double time = 0;
  logged[fmi3Warning] = logged[fmi3Discard] = 0;
  EXPECT(do_step(i, &time, 0.01) == fmi3Warning &&
         logged[fmi3Warning] == 0);  // nothing was measured, and logging is off
  fmi3String categories[] = {"logStatusWarning", "logStatusDiscard"};
  EXPECT(F(fmi3SetDebugLogging)(i, true, 2, categories) == fmi3OK);
  EXPECT(F(fmi3Reset)(i) == fmi3OK && F(fmi3EnterInitializationMode)(i, 0, 0, 0, 0, 0) == fmi3OK &&
         F(fmi3ExitInitializationMode)(i) == fmi3OK);
  time = 0;
  EXPECT(do_step(i, &time, 0.01) == fmi3Warning && do_step(i, &time, 0.01) == fmi3Warning);
  EXPECT(logged[fmi3Warning] == 1 && strcmp(last_category, "logStatusWarning") == 0 &&
         strstr(last_message, "HELD") != NULL);  // logged once
  const double before = time;
  EXPECT(do_step(i, &time, 1e9) == fmi3Discard && logged[fmi3Discard] == 1 && time == before);
  EXPECT(do_step(i, &time, 0.01) == fmi3Warning);  // the step that was too long changed nothing
  fmi3Int64 status;
  EXPECT(F(fmi3GetInt64)(i, &status_reference, 1, &status, 1) == fmi3OK && status == NAMED(HELD));
  EXPECT(F(fmi3SetDebugLogging)(i, false, 0, NULL) == fmi3OK);
  EXPECT(do_step(i, &time, 1e9) == fmi3Discard && logged[fmi3Discard] == 1);
  fmi3String unknown = "logEverything";
  REFUSED(F(fmi3SetDebugLogging)(i, true, 1, &unknown));
  F(fmi3FreeInstance)(i);
}

// A finite reading beyond float is out of range and clamped; an infinite one is missing.
static void clamps_huge_readings_and_holds_missing_ones(void) {
  fmi3Instance i = begun(0);
  double time = 0;
  for (int k = 0; k < 4; ++k) {
    const double huge[] = {0.25, 1e300, HUGE_VAL, -1e300};
    for (unsigned j = 0; j < kNy; ++j) {
      const fmi3ValueReference reference = measured + j;
      EXPECT(F(fmi3SetFloat64)(i, &reference, 1, &huge[k], 1) == fmi3OK);
    }
    EXPECT(do_step(i, &time, 0.01) <= fmi3Warning);
  }
  F(fmi3FreeInstance)(i);
}

static void refuses_what_an_observer_has_no_use_for(void) {
  fmi3Instance instances[] = {begun(0), NULL};
  const fmi3ValueReference r = estimate;
  size_t sizes[1] = {0};
  double number = 0;
  fmi3Boolean truth = false;
  for (int n = 0; n < 2; ++n) {
    fmi3Instance i = instances[n];
#define NO(name, ...) EXPECT(F(name)(i __VA_OPT__(, ) __VA_ARGS__) == fmi3Error && errors_logged() == 1 - n)
#define NO_TYPE(type)                                                    \
  do {                                                                   \
    fmi3##type none[1] = {0};                                            \
    NO(fmi3Get##type, &r, 1, none, 1);                                   \
    NO(fmi3Set##type, &r, 1, none, 1);                                   \
    if (n == 0) EXPECT(F(fmi3Get##type)(i, NULL, 0, NULL, 0) == fmi3OK); \
  } while (0)
    NO_TYPE(Float32);
    NO_TYPE(Int8);
    NO_TYPE(UInt8);
    NO_TYPE(Int16);
    NO_TYPE(UInt16);
    NO_TYPE(Int32);
    NO_TYPE(UInt32);
    NO_TYPE(UInt64);
    NO_TYPE(String);
    NO(fmi3GetBinary, &r, 1, sizes, NULL, 1);
    NO(fmi3SetBinary, &r, 1, sizes, NULL, 1);
    NO(fmi3GetClock, &r, 1, &truth);
    NO(fmi3SetClock, &r, 1, &truth);
    NO(fmi3GetNumberOfVariableDependencies, r, sizes);
    NO(fmi3GetVariableDependencies, r, sizes, NULL, sizes, NULL, 0);
    NO(fmi3GetDirectionalDerivative, &r, 1, &measured, 1, &number, 1, &number, 1);
    NO(fmi3GetAdjointDerivative, &r, 1, &measured, 1, &number, 1, &number, 1);
    NO(fmi3EnterConfigurationMode);
    NO(fmi3ExitConfigurationMode);
    NO(fmi3EnterEventMode);
    NO(fmi3EnterStepMode);
    NO(fmi3GetIntervalDecimal, &r, 1, &number, NULL);
    NO(fmi3GetIntervalFraction, &r, 1, NULL, NULL, NULL);
    NO(fmi3GetShiftDecimal, &r, 1, &number);
    NO(fmi3GetShiftFraction, &r, 1, NULL, NULL);
    NO(fmi3SetIntervalDecimal, &r, 1, &number);
    NO(fmi3SetIntervalFraction, &r, 1, NULL, NULL);
    NO(fmi3SetShiftDecimal, &r, 1, &number);
    NO(fmi3SetShiftFraction, &r, 1, NULL, NULL);
    NO(fmi3EvaluateDiscreteStates);
    NO(fmi3UpdateDiscreteStates, &truth, &truth, &truth, &truth, &truth, &number);
    NO(fmi3EnterContinuousTimeMode);
    NO(fmi3CompletedIntegratorStep, true, &truth, &truth);
    NO(fmi3SetTime, 0.0);
    NO(fmi3SetContinuousStates, &number, 1);
    NO(fmi3GetContinuousStateDerivatives, &number, 1);
    NO(fmi3GetEventIndicators, &number, 1);
    NO(fmi3GetContinuousStates, &number, 1);
    NO(fmi3GetNominalsOfContinuousStates, &number, 1);
    NO(fmi3GetNumberOfEventIndicators, sizes);
    NO(fmi3GetNumberOfContinuousStates, sizes);
    NO(fmi3GetOutputDerivatives, &r, 1, NULL, &number, 1);
    NO(fmi3ActivateModelPartition, r, 0.0);
  }
  F(fmi3FreeInstance)(instances[0]);
}

int main(int argc, char** argv) {
  open_library(argc, argv);
  attribute("<fmiModelDescription", "instantiationToken", token, sizeof token);
  measured = reference_of("measured.");
  if (kNu > 0) input = reference_of("input.");
  estimate = reference_of("estimate.");
  status_reference = reference_of("status\"");
  domain = reference_of("in_domain\"");
  latent = reference_of("z\"");
  initial = reference_of("initial_z\"");
  EXPECT(strcmp(F(fmi3GetVersion)(), "3.0") == 0);
  takes_only_its_own_token();
  replays_and_disturbs_no_other();
  continues_from_saved_states();
  refuses_wrong_calls();
  tells_what_it_is_asked_to();
  clamps_huge_readings_and_holds_missing_ones();
  refuses_what_an_observer_has_no_use_for();
  return 0;
}
