// SPDX-License-Identifier: MIT
// The work queue: starts an exported module, runs it over the golden readings, sometimes skipping a run, and compares
// its published estimates with the C99 pair bit for bit. MODULE is the file of the module.
#include MODULE

static hrt_abstime now_us = 1000000;
hrt_abstime hrt_absolute_time() {
  return now_us;
}

#define EXPECT(condition) \
  if (!(condition)) return printf("FAILED  line %d: %s\n", __LINE__, #condition), 1

static int command(const char* word) {
  char program[] = "observer", argument[20];
  snprintf(argument, sizeof argument, "%s", word);
  char* arguments[] = {program, argument, nullptr};
  return NAMED(observer_main)(2, arguments);
}

int main() {
  using px4::ScheduledWorkItem;
  using Published = uORB::Publication<debug_array_s>;
  EXPECT(command("status") == PX4_ERROR && command("start") == PX4_OK && ScheduledWorkItem::scheduled != nullptr);
  const uint32_t period_us = ScheduledWorkItem::scheduled->interval;
  EXPECT(period_us > 0);
  NAMED(observer) observer;
  NAMED(init)(&observer);
#ifdef NLO_MONITOR
  NAMED(monitor) monitor;
  NAMED(monitor_reset)(&monitor);
  int alarms = 0;
#endif
  constexpr int kSamples = sizeof(NAMED(replay_samples)) / sizeof(NAMED(replay_samples)[0]);
  for (int k = 0; k < kSamples; ++k) {
    auto sample = NAMED(replay_samples)[k];
    replayed = k;
    const bool lost = k % 10 == 5;
    now_us += lost ? 3 * period_us : period_us + (k % 3 == 0 ? period_us / 4 : 0);
    const NLO_SCALAR since = static_cast<NLO_SCALAR>(3 * period_us) * static_cast<NLO_SCALAR>(1e-6);
#ifdef NLO_MONITOR
    NAMED(usable_outputs_dt)(&monitor, &observer, sample.y, lost ? since : 0, sample.y);
#endif
#ifdef NLO_DRIVEN
    const int want =
        lost ? NAMED(step_dt)(&observer, sample.y, sample.u, since) : NAMED(step)(&observer, sample.y, sample.u);
#else
    const int want = lost ? NAMED(step_dt)(&observer, sample.y, since) : NAMED(step)(&observer, sample.y);
#endif
    ScheduledWorkItem::scheduled->Run();
    NLO_SCALAR x_hat[NAMED(NX)];
    NAMED(estimate)(&observer, x_hat);
    const debug_array_s& published = Published::last;
    EXPECT(Published::count == k + 1 && published.timestamp == now_us &&
           strlen(published.name) < sizeof(published.name));
    for (int i = 0; i < NAMED(NX); ++i) EXPECT(published.data[i] == static_cast<float>(x_hat[i]));
    EXPECT(published.data[NAMED(NX)] == static_cast<float>(want));
    EXPECT((published.data[NAMED(NX) + 1] == 1.f) == NAMED(in_domain)(&observer));
#ifdef NLO_MONITOR
    const auto alarm = NAMED(watch)(&monitor, &observer, x_hat);
    EXPECT(published.data[NAMED(NX) + 2] == static_cast<float>(alarm));
    alarms += alarm != NAMED(NO_ALARM);
#endif
  }
#ifdef NLO_MONITOR
  EXPECT(alarms > 0);
#endif
  EXPECT(command("status") == 0 && command("dance") == 0 && command("stop") == PX4_OK);
  ScheduledWorkItem::scheduled->Run();
  EXPECT(ScheduledWorkItem::scheduled == nullptr && Published::count == kSamples);
  return 0;
}
