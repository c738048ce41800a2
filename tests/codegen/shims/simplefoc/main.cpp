// SPDX-License-Identifier: MIT
// A loop of SimpleFOC around an exported sensor and a simulated encoder that makes many turns in both directions:
// uneven and late steps, a long rest, an overflow of the clock and a clock that goes back. Each step is compared with
// the C99 pair bit for bit. SENSOR is the header.
#include SENSOR

#include <stdio.h>
#include <string.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAMED(word) JOIN(NLO_NAME, _##word)
#define EXPECT(condition) \
  if (!(condition)) return printf("FAILED  line %d, loop %d: %s\n", __LINE__, loop, #condition), 1

static uint32_t now_us = 0xffff0000U;
unsigned long _micros() {
  return now_us;
}

class Encoder : public Sensor {
 public:
  void init() override { Sensor::init(); }
  int needsSearch() override { return 7; }
  float getSensorAngle() override {
    const double turns = truth / static_cast<double>(_2PI);
    return static_cast<float>(floor((turns - floor(turns)) * 4096) / 4096 * static_cast<double>(_2PI));
  }
  double truth = 0;
};

static int steps = 0;
static NLO_SCALAR pattern(int channel) {
  if ((steps + channel) % 17 == 16) return static_cast<NLO_SCALAR>(NAN);
  return static_cast<NLO_SCALAR>((steps * (channel + 3)) % 29 - 14) / static_cast<NLO_SCALAR>(16);
}

#ifdef NLO_DRIVEN
static void give(NLO_SCALAR* y, NLO_SCALAR* u) {
  for (int j = 0; j < NAMED(NU); ++j) u[j] = pattern(40 + j);
#else
static void give(NLO_SCALAR* y) {
#endif
  for (int j = 0; j < NAMED(NY); ++j)
    if (j != NLO_ANGLE) y[j] = pattern(j);
}

int main() {
  Encoder encoder;
  encoder.init();
  NAMED(sensor) sensor(encoder, give);
  sensor.init();
  NAMED(observer) observer;
  NAMED(init)(&observer);
#ifdef NLO_MONITOR
  NAMED(monitor) monitor;
  NAMED(monitor_reset)(&monitor);
  bool alarmed = false;
#endif
  const uint32_t period = NLO_PERIOD_US;
  uint32_t last = now_us - period, late = 0;  // time and delay of the latest step
  const double fastest =
      0.25e6 / period;  // rad/s: less than a fifth of a turn per late update, since an encoder may miss larger moves
  int irregular = 0, regular = 0, begun_anew = 0, moved = 0;
  for (int loop = 0; loop < 6000; ++loop) {
    uint32_t passed = period / 9 + static_cast<uint32_t>(loop * 7919 % 1000) * (period / 4) / 1000;
    if (loop % 50 == 49) passed = period * 17 / 5;
    if (loop >= 2000 && loop < 2100) passed = period + static_cast<uint32_t>(loop % 3) - 1;  // a timer
    const bool rests = loop == 3000, falls_back = loop == 4000;
    if (rests) passed = period * 5000;
    if (loop == 0) passed = 0;  // init() has already stepped
    now_us += falls_back ? 0xf0000000U : passed;
    encoder.truth += fastest * cos(loop * 0.003) * 1e-6 * (falls_back || rests ? 0 : passed);

    if (loop == 0) last = now_us - period;
    if (loop > 0) sensor.update();
    uint32_t since = now_us - last;
    if (falls_back) since = period, last = now_us - period;
#ifdef NLO_WHOLE_PERIODS
    const bool due = since >= period;
#else
    const bool due = since >= period - period / 256;
#endif
    if (due) {
      if (2 * static_cast<uint64_t>(since) >= 3 * static_cast<uint64_t>(period)) ++late;
      NLO_SCALAR y[NAMED(NY)];
#if NLO_ANGLE >= 0
      y[NLO_ANGLE] = static_cast<NLO_SCALAR>(NLO_TURNS ? encoder.getMechanicalAngle() : encoder.getPreciseAngle());
#endif
#ifdef NLO_DRIVEN
      NLO_SCALAR u[NAMED(NU)];
      give(y, u);
#define U , u
#else
      give(y);
#define U
#endif
#ifdef NLO_MONITOR
      NAMED(usable_outputs_dt)
      (&monitor, &observer, y, static_cast<NLO_SCALAR>(since) * static_cast<NLO_SCALAR>(1e-6), y);
#endif
#ifdef NLO_WHOLE_PERIODS
      const NLO_SCALAR seconds = static_cast<NLO_SCALAR>(since / period) * static_cast<NLO_SCALAR>(NLO_PERIOD);
      const bool even = since / period == 1;
      last += since / period * period;
#else
      const NLO_SCALAR seconds = static_cast<NLO_SCALAR>(since) * static_cast<NLO_SCALAR>(1e-6);
      const bool even = since <= period + period / 256;
      last = now_us;
#endif
      ++(even ? regular : irregular);
      NAMED(status) status = even ? NAMED(step)(&observer, y U) : NAMED(step_dt)(&observer, y U, seconds);
      if (rests) {
        EXPECT(status == NAMED(REJECTED));
        NAMED(reset)(&observer);
#ifdef NLO_MONITOR
        NAMED(monitor_reset)(&monitor);
#endif
        status = NAMED(step)(&observer, y U);
        ++begun_anew;
      }
      ++steps;
    }
    NLO_SCALAR x_hat[NAMED(NX)];
    NAMED(estimate)(&observer, x_hat);
#ifdef NLO_MONITOR
    if (due) NAMED(watch)(&monitor, &observer, x_hat);
    EXPECT(sensor.alarm() == static_cast<NAMED(alarm)>(monitor.alarm));
    alarmed = alarmed || sensor.alarm() != NAMED(NO_ALARM);
#endif
    EXPECT(sensor.steps() == static_cast<uint32_t>(steps) && sensor.late() == late);
    for (int i = 0; i < NAMED(NX); ++i) {
      const NLO_SCALAR estimate = sensor.estimate(i);
      EXPECT(memcmp(&estimate, &x_hat[i], sizeof(estimate)) == 0);
    }
    const NLO_SCALAR none = sensor.estimate(NAMED(NX)), before = sensor.estimate(-1);
    EXPECT(none != none && before != before);
    moved += sensor.getVelocity() < static_cast<float>(x_hat[NLO_VELOCITY]) ||
             sensor.getVelocity() > static_cast<float>(x_hat[NLO_VELOCITY]);
    EXPECT(moved == 0);
    EXPECT(sensor.status() == NAMED(last_status)(&observer) && sensor.in_domain() == NAMED(in_domain)(&observer));
    Sensor& base = sensor;
    const float angles[] = {base.getAngle(), base.getMechanicalAngle()},
                want[] = {encoder.getAngle(), encoder.getMechanicalAngle()};
    EXPECT(memcmp(angles, want, sizeof(want)) == 0 && base.getFullRotations() == encoder.getFullRotations());
    EXPECT(fabs(base.getPreciseAngle() - encoder.getPreciseAngle()) <= 0 && base.needsSearch() == 7);
    EXPECT(fabs(base.getPreciseAngle() - encoder.truth) < 0.01);
    const double difference =
        loop % 50 == 10 || loop % 50 == 40 ? static_cast<double>(sensor.Sensor::getVelocity()) : 0;
    if (loop % 50 == 40 && loop < 3000) EXPECT(fabs(difference / fastest - cos(loop * 0.003)) < 0.1);
  }
  int loop = 6000;
  EXPECT(begun_anew == 1 && irregular > 100 && regular > 90 && late > 50);
#ifdef NLO_MONITOR
  EXPECT(alarmed);
#endif
  sensor.reset();
  now_us += 5 * period;
  sensor.update();  // the first update, after any time
  EXPECT(sensor.steps() == static_cast<uint32_t>(steps + 1) && sensor.late() == late);
  return 0;
}
