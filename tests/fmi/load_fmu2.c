// SPDX-License-Identifier: MIT
// An importer of FMI 2.0 for one FMU: it loads the library, uses only what modelDescription.xml declares, and compares
// all estimates with the C99 pair, bit for bit. Compile it with the options of load_fmu.c.
//   load_fmu2 LIBRARY modelDescription.xml
#include "tests/fmi/importer.h"

#include <stdarg.h>

static int logged[6];
static char last_message[400];
static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String format, ...) {
  EXPECT(environment == logged && name != NULL && strncmp(category, "logStatus", 9) == 0);
  ++logged[status];
  va_list values;
  va_start(values, format);
  vsnprintf(last_message, sizeof last_message, format, values);
  va_end(values);
}
static const fmi2CallbackFunctions kCallbacks = {log_message, calloc, free, NULL, logged};
// Returns whether the call returned an error and logged a message that begins with `function`.
static int is_refused(fmi2Status answer, const char* function) {
  const int errors = logged[fmi2Error];
  logged[fmi2Error] = 0;
  return answer == fmi2Error && errors == 1 && strncmp(last_message, function, strlen(function)) == 0;
}

static char guid[80];

static fmi2Component begun(double start) {
  fmi2Component c = F(fmi2Instantiate)("observer", fmi2CoSimulation, guid, NULL, &kCallbacks, 0, 0);
  EXPECT(c != NULL && F(fmi2SetupExperiment)(c, 0, 0, start, 0, 0) == fmi2OK);
  EXPECT(F(fmi2EnterInitializationMode)(c) == fmi2OK && F(fmi2ExitInitializationMode)(c) == fmi2OK);
  return c;
}

// Steps the FMU and the pair over sample `k`, optionally with halved readings, and compares all variables.
static void step_both(fmi2Component c, double* time, Pair* pair, int k, bool halved) {
  const PairStep want = step_pair(pair, k, halved);
  fmi2ValueReference references[kNy + kNu];
  for (int j = 0; j < kNy; ++j) references[j] = reference_of("measured.") + (unsigned)j;
  for (int j = 0; j < kNu; ++j) references[kNy + j] = reference_of("input.") + (unsigned)j;
  EXPECT(F(fmi2SetReal)(c, references, kNy + kNu, want.given) == fmi2OK);
  EXPECT(F(fmi2DoStep)(c, *time, want.period, 1) == (want.is_ok ? fmi2OK : fmi2Warning));
  *time += want.period;
#ifdef NLO_MONITORED
  const fmi2ValueReference alarm_reference = reference_of("alarm\"");
  fmi2Integer alarm = -1;
  EXPECT(F(fmi2GetInteger)(c, &alarm_reference, 1, &alarm) == fmi2OK && alarm == want.alarm);
#endif
  double last_time = -1;
  EXPECT(F(fmi2GetRealStatus)(c, fmi2LastSuccessfulTime, &last_time) == fmi2OK && last_time == *time);

  for (int n = 0; n < kNx + kNz; ++n) {
    const double number = (double)(n < kNx ? want.x_hat[n] : pair->observer.z[n - kNx]);
    const fmi2ValueReference r =
        n < kNx ? reference_of("estimate.") + (unsigned)n : reference_of("z[1]") + (unsigned)(n - kNx);
    double got = 0;
    EXPECT(F(fmi2GetReal)(c, &r, 1, &got) == fmi2OK && memcmp(&got, &number, sizeof number) == 0);
  }
  const fmi2ValueReference status_reference = reference_of("status\""), domain = reference_of("in_domain\"");
  fmi2Integer status = -1;
  fmi2Boolean inside = -1;
  EXPECT(F(fmi2GetInteger)(c, &status_reference, 1, &status) == fmi2OK && status == (int)want.status);
  EXPECT(F(fmi2GetBoolean)(c, &domain, 1, &inside) == fmi2OK && inside == NAMED(in_domain)(&pair->observer));
}

static void replays_and_disturbs_no_other(void) {
  double time = 3, other_time = 0;
  fmi2Component one = begun(time), other = begun(other_time);
  Pair pair, other_pair;
  begin(&pair);
  begin(&other_pair);
  for (int k = 0; k < kSamples; ++k) {
    step_both(one, &time, &pair, k, 0);
    step_both(other, &other_time, &other_pair, k, 1);
  }
  F(fmi2FreeInstance)(other);
  EXPECT(F(fmi2Reset)(one) == fmi2OK && F(fmi2EnterInitializationMode)(one) == fmi2OK &&
         F(fmi2ExitInitializationMode)(one) == fmi2OK);
  begin(&pair);
  time = 0;
  for (int k = 0; k < kSamples / 2; ++k) step_both(one, &time, &pair, k, 0);
  EXPECT(F(fmi2Terminate)(one) == fmi2OK);
  F(fmi2FreeInstance)(one);
}

static void continues_from_saved_states(void) {
  const int half = kSamples / 2;
  double time = 0;
  fmi2Component c = begun(time), fresh = begun(0);
  Pair pair;
  begin(&pair);
  for (int k = 0; k < half; ++k) step_both(c, &time, &pair, k, 0);
  fmi2FMUstate state = NULL, loaded = NULL;
  size_t size = 0;
  EXPECT(F(fmi2GetFMUstate)(c, &state) == fmi2OK && F(fmi2SerializedFMUstateSize)(c, state, &size) == fmi2OK);
  fmi2Byte* bytes = malloc(size);
  EXPECT(F(fmi2SerializeFMUstate)(c, state, bytes, size) == fmi2OK);
  bytes[size / 2] ^= 1;
  EXPECT(is_refused(F(fmi2DeSerializeFMUstate)(fresh, bytes, size, &loaded), "fmi2DeSerializeFMUstate: damaged"));
  bytes[size / 2] ^= 1;
  EXPECT(F(fmi2DeSerializeFMUstate)(fresh, bytes, size, &loaded) == fmi2OK);
  EXPECT(F(fmi2SetFMUstate)(fresh, loaded) == fmi2OK && F(fmi2FreeFMUstate)(fresh, &loaded) == fmi2OK);
  double fresh_time = time;
  Pair fresh_pair = pair;
  for (int k = half; k < kSamples; ++k) step_both(fresh, &fresh_time, &fresh_pair, k, 0);
  for (int k = half; k < kSamples; ++k) step_both(c, &time, &pair, k, 0);
  EXPECT(F(fmi2FreeFMUstate)(c, &state) == fmi2OK && state == NULL);
  free(bytes);
  F(fmi2FreeInstance)(c);
  F(fmi2FreeInstance)(fresh);
}

static void refuses_wrong_calls(void) {
  EXPECT(F(fmi2Instantiate)("x", fmi2CoSimulation, "{0}", NULL, &kCallbacks, 0, 1) == NULL);
  EXPECT(is_refused(fmi2Error, "fmi2Instantiate: ") && strstr(last_message, guid) != NULL);
  EXPECT(F(fmi2Instantiate)("x", fmi2ModelExchange, guid, NULL, &kCallbacks, 0, 1) == NULL);
  EXPECT(is_refused(fmi2Error, "fmi2Instantiate: this FMU is for co-simulation"));
  EXPECT(F(fmi2Instantiate)("x", fmi2CoSimulation, "{0}", NULL, NULL, 0, 1) == NULL);

  fmi2Component c = F(fmi2Instantiate)("observer", fmi2CoSimulation, guid, NULL, &kCallbacks, 0, 0);
  EXPECT(is_refused(F(fmi2DoStep)(c, 0, 0.01, 1), "fmi2DoStep: not in this mode"));
  EXPECT(is_refused(F(fmi2SetupExperiment)(c, 0, 0, 1, 1, 0), "fmi2SetupExperiment: "));
  EXPECT(F(fmi2SetupExperiment)(c, 0, 0, 0, 1, 10) == fmi2OK && F(fmi2EnterInitializationMode)(c) == fmi2OK);

  // Sets one element of the latent state before the first reading.
  const fmi2ValueReference measured = reference_of("measured."), estimate = reference_of("estimate."),
                           element = reference_of("initial_z[1]"), array = reference_of("initial_z[1]") + kNz;
  NAMED(observer) observer;
  NAMED(init)(&observer);
  observer.z[0] += (Scalar)0.125;
  const double shifted = (double)observer.z[0];
  Scalar x_hat[kNx];
  double got = 0;
  NAMED(estimate)(&observer, x_hat);
  EXPECT(F(fmi2SetReal)(c, &element, 1, &shifted) == fmi2OK);
  EXPECT(F(fmi2GetReal)(c, &estimate, 1, &got) == fmi2OK && got == (double)x_hat[0]);
  EXPECT(F(fmi2GetReal)(c, &element, 1, &got) == fmi2OK && got == shifted);
  EXPECT(F(fmi2ExitInitializationMode)(c) == fmi2OK);
  EXPECT(is_refused(F(fmi2SetReal)(c, &element, 1, &shifted), "fmi2SetReal: "));
  EXPECT(is_refused(F(fmi2GetReal)(c, &array, 1, &got), "fmi2GetReal: "));

  // A call sets all values or none.
  const fmi2ValueReference input_and_output[] = {measured, estimate};
  const double half[] = {0.5, 0.5}, quarter = 0.25;
  EXPECT(F(fmi2SetReal)(c, &measured, 1, &quarter) == fmi2OK);
  EXPECT(is_refused(F(fmi2SetReal)(c, input_and_output, 2, half), "fmi2SetReal: "));
  EXPECT(F(fmi2GetReal)(c, &measured, 1, &got) == fmi2OK && got == 0.25);
  EXPECT(is_refused(F(fmi2SetReal)(c, NULL, 1, half), "fmi2SetReal: a pointer is null"));
  EXPECT(F(fmi2SetReal)(c, NULL, 0, NULL) == fmi2OK && F(fmi2SetString)(c, NULL, 0, NULL) == fmi2OK);
  fmi2String word = "x";
  fmi2Integer number = 0;
  EXPECT(is_refused(F(fmi2SetString)(c, &measured, 1, &word), "fmi2SetString: "));
  EXPECT(is_refused(F(fmi2SetInteger)(c, &measured, 1, &number), "fmi2SetInteger: "));
  EXPECT(is_refused(F(fmi2SetBoolean)(c, &measured, 1, &number), "fmi2SetBoolean: "));
  EXPECT(is_refused(F(fmi2GetInteger)(c, &measured, 1, &number), "fmi2GetInteger: "));
  EXPECT(is_refused(F(fmi2CancelStep)(c), "fmi2CancelStep: "));
  EXPECT(
      is_refused(F(fmi2GetDirectionalDerivative)(c, NULL, 0, NULL, 0, NULL, NULL), "fmi2GetDirectionalDerivative: "));
  EXPECT(is_refused(F(fmi2SetRealInputDerivatives)(c, NULL, 0, NULL, NULL), "fmi2SetRealInputDerivatives: "));
  EXPECT(is_refused(F(fmi2GetRealOutputDerivatives)(c, NULL, 0, NULL, NULL), "fmi2GetRealOutputDerivatives: "));

  // A step that is too long changes nothing.
  EXPECT(is_refused(F(fmi2DoStep)(c, 0, 10.1, 1), "fmi2DoStep: would end behind the stop time"));
  F(fmi2FreeInstance)(c);
  c = begun(0);
  fmi2Status step_status = fmi2Fatal;
  fmi2Boolean terminated = 1;
  EXPECT(F(fmi2DoStep)(c, 0, 1e9, 1) == fmi2Discard && F(fmi2DoStep)(c, 0, 0.01, 1) == fmi2Warning);
  EXPECT(F(fmi2GetStatus)(c, fmi2DoStepStatus, &step_status) == fmi2OK && step_status == fmi2Warning);
  EXPECT(F(fmi2GetBooleanStatus)(c, fmi2Terminated, &terminated) == fmi2OK && terminated == 0);
  EXPECT(F(fmi2GetIntegerStatus)(c, fmi2DoStepStatus, &number) == fmi2Discard);
  EXPECT(F(fmi2GetStringStatus)(c, fmi2PendingStatus, &word) == fmi2Discard);
  fmi2String category = "logStatusDiscard";
  EXPECT(F(fmi2SetDebugLogging)(c, 1, 1, &category) == fmi2OK && F(fmi2DoStep)(c, 0.01, 1e9, 1) == fmi2Discard);
  EXPECT(logged[fmi2Discard] == 1 && strncmp(last_message, "fmi2DoStep: a step of", 21) == 0);
  F(fmi2FreeInstance)(c);
  F(fmi2FreeInstance)(NULL);
  EXPECT(F(fmi2DoStep)(NULL, 0, 1, 1) == fmi2Error && F(fmi2GetReal)(NULL, &measured, 1, &got) == fmi2Error);
  EXPECT(F(fmi2Reset)(NULL) == fmi2Error && F(fmi2SetReal)(NULL, &measured, 1, &got) == fmi2Error);
}

int main(int argc, char** argv) {
  open_library(argc, argv);
  attribute("<fmiModelDescription", "guid", guid, sizeof guid);
  EXPECT(strcmp(F(fmi2GetVersion)(), "2.0") == 0 && strcmp(F(fmi2GetTypesPlatform)(), "default") == 0);
  replays_and_disturbs_no_other();
  continues_from_saved_states();
  refuses_wrong_calls();
  return 0;
}
