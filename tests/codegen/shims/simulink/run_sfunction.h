// SPDX-License-Identifier: MIT
// The engine: two blocks of one S-function over the golden readings, compared with the C99 pair bit for bit. As in real
// engines, outputs are requested several times per step, and an operating point is saved and restored.
#include <stdio.h>
#include <string.h>

#define EXPECT(condition)                                                             \
  do {                                                                                \
    if (!(condition)) printf("FAILED  line %d: %s\n", __LINE__, #condition), exit(1); \
  } while (0)
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAMED(word) JOIN(NLO_NAME, _##word)

enum { kNx = NAMED(NX), kNy = NAMED(NY), kSamples = sizeof(NAMED(replay_samples)) / sizeof(NAMED(replay_samples)[0]) };

#ifdef NLO_MONITOR
static int alarms = 0;
#endif

static void allocate_signals(ShimPort* ports, int count) {
  for (int p = 0; p < count; ++p) {
    EXPECT(ports[p].width > 0);
    ports[p].signal = calloc((size_t)ports[p].width, sizeof(double));
  }
}

static void free_signals(ShimPort* ports, int count) {
  for (int p = 0; p < count; ++p) free(ports[p].signal);
}

#ifdef NLO_MONITOR
enum { kOutputs = 4 };
typedef NAMED(monitor) Monitor;
#else
enum { kOutputs = 3 };
typedef char Monitor;
#endif
// The pair that a block must reproduce.
typedef struct {
  NAMED(observer) observer;
  Monitor monitor;
} Pair;

static void begin(Pair* pair) {
  NAMED(init)(&pair->observer);
#ifdef NLO_MONITOR
  NAMED(monitor_reset)(&pair->monitor);
#endif
}

static SimStruct block(void) {
  SimStruct s = {.given_parameters = 0};
  mdlInitializeSizes(&s);
  mdlInitializeSampleTimes(&s);
  EXPECT(s.continuous == 0 && s.discrete == 0 && s.sample_times == 1 && s.offset == 0 && s.sample_time == NLO_PERIOD);
  EXPECT(s.outputs == kOutputs && s.output[0].width == kNx && s.output[1].width == 1 && s.output[2].width == 1);
  EXPECT(s.output[0].type == SS_DOUBLE && s.output[1].type == SS_INT32 && s.output[2].type == SS_BOOLEAN);
#ifdef NLO_MONITOR
  EXPECT(s.output[3].width == 1 && s.output[3].type == SS_INT32);
#endif
  EXPECT(s.input[0].width == kNy && s.compliance == USE_DEFAULT_OPERATING_POINT);
  for (int p = 0; p < s.inputs; ++p) EXPECT(s.input[p].feedthrough == 1 && s.input[p].contiguous == 1);
  allocate_signals(s.input, s.inputs);
  allocate_signals(s.output, s.outputs);
  allocate_signals(s.work, s.works);
  mdlInitializeConditions(&s);
  return s;
}

static void step_both(SimStruct* s, Pair* pair, int k, bool halved) {
  NAMED(observer)* observer = &pair->observer;
  NAMED(replay_sample) sample = NAMED(replay_samples)[k];
  for (int j = 0; j < kNy; ++j) s->input[0].signal[j] = (double)(sample.y[j] = halved ? sample.y[j] / 2 : sample.y[j]);
#ifdef NLO_MONITOR
  NAMED(usable_outputs)(&pair->monitor, observer, sample.y, sample.y);
#endif
#ifdef NLO_DRIVEN
  EXPECT(s->inputs == 2 && s->input[1].width == NAMED(NU));
  for (int j = 0; j < NAMED(NU); ++j) s->input[1].signal[j] = (double)sample.u[j];
  const int want = (int)NAMED(step)(observer, sample.y, sample.u);
#else
  EXPECT(s->inputs == 1);
  const int want = (int)NAMED(step)(observer, sample.y);
#endif
  for (int times = 0; times < 3; ++times) mdlOutputs(s, 0);
  mdlUpdate(s, 0);
  NLO_SCALAR x_hat[kNx];
  NAMED(estimate)(observer, x_hat);
  for (int i = 0; i < kNx; ++i) EXPECT(s->output[0].signal[i] == (double)x_hat[i]);
  int32_T status;
  boolean_T in_domain;
  memcpy(&status, s->output[1].signal, sizeof(status));
  memcpy(&in_domain, s->output[2].signal, sizeof(in_domain));
  EXPECT(status == want && in_domain == NAMED(in_domain)(observer));
#ifdef NLO_MONITOR
  const int32_T seen = (int32_T)NAMED(watch)(&pair->monitor, observer, x_hat);
  int32_T alarm;
  memcpy(&alarm, s->output[3].signal, sizeof(alarm));
  EXPECT(alarm == seen);
  alarms += alarm != (int32_T)NAMED(NO_ALARM);
#endif
}

int main(void) {
  SimStruct one = block(), other = block(), wrong = {.given_parameters = 1};
  mdlInitializeSizes(&wrong);
  EXPECT(wrong.inputs == 0);
  Pair pair, other_pair, saved_pair;
  begin(&pair);
  begin(&other_pair);
  saved_pair = pair;
  const size_t bytes = (size_t)one.work[0].width * sizeof(double);
  EXPECT(bytes >= sizeof(pair.observer));
  double* saved = malloc(bytes);
  for (int k = 0; k < kSamples; ++k) {
    if (k == kSamples / 2) memcpy(saved, one.work[0].signal, bytes), saved_pair = pair;
    step_both(&one, &pair, k, false);
    step_both(&other, &other_pair, k, true);
  }
  memcpy(one.work[0].signal, saved, bytes);
  pair = saved_pair;
  for (int k = kSamples / 2; k < kSamples; ++k) step_both(&one, &pair, k, false);
  mdlInitializeConditions(&one);
  begin(&pair);
  for (int k = 0; k < kSamples / 4; ++k) step_both(&one, &pair, k, false);
#ifdef NLO_MONITOR
  EXPECT(alarms > 0);
#endif
  SimStruct* blocks[] = {&one, &other};
  for (int b = 0; b < 2; ++b) {
    mdlTerminate(blocks[b]);
    free_signals(blocks[b]->input, blocks[b]->inputs);
    free_signals(blocks[b]->output, blocks[b]->outputs);
    free_signals(blocks[b]->work, blocks[b]->works);
  }
  free(saved);
  return 0;
}
