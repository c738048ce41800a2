// SPDX-License-Identifier: MIT
// Counts the cycles of a step and of an estimate on an ATmega328P, and the stack that they use. NLO_NAME: a C99 export.
// Timer 1 ticks every 64 cycles, which is checked with code of known length.
#include <avr/io.h>
#include <stdlib.h>
#include <util/delay_basic.h>

#include NLO_HEADER
#include "toolchains/semihosting.h"

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(word) JOIN(NLO_NAME, _##word)

static OF(observer) observer;
static const float y[OF(NY)] = {0.5f};
static float x_hat[OF(NX)];

static void step(void) {
  OF(step)(&observer, y);
}
static void estimate(void) {
  OF(estimate)(&observer, x_hat);
}
static void known_length(void) {
  _delay_loop_2(16000);  // 64,000 cycles
}

// Returns the cycles of one call, at most 4 million.
static __attribute__((noinline)) uint32_t cycles(void (*call)(void)) {
  TCCR1B = _BV(CS11) | _BV(CS10);
  TCNT1 = 0;
  call();
  return (uint32_t)TCNT1 * 64;
}

// Returns the number of bytes below the caller's frame that a call writes: fills them before and compares after the
// call.
static __attribute__((noinline)) unsigned stack_of(void (*call)(void)) {
  extern char __heap_start;
  const char paint = 0x5a;
  char* const top = (char*)SP;
  for (volatile char* at = &__heap_start; at < top - 16; ++at) *at = paint;
  call();
  char* lowest = &__heap_start;
  while (*(volatile char*)lowest == paint) ++lowest;
  return (unsigned)(top - lowest);
}

static void put(const char* name, uint32_t value) {
  char digits[12];
  board_write(name);
  board_write(ultoa(value, digits, 10));
}

int main(void) {
  OF(init)(&observer);
  step();  // not counted: the first step only starts the observer
  const uint32_t delay = cycles(known_length);
  const unsigned of_step = stack_of(step), of_estimate = stack_of(estimate);
  put("step ", cycles(step));
  put(" estimate ", cycles(estimate));
  put(" stack ", of_step > of_estimate ? of_step : of_estimate);
  put(" observer ", sizeof(observer));
  board_write("\n");
  board_exit(delay < 63900 || delay > 64200 || !(x_hat[0] < 1e6f && x_hat[0] > -1e6f));
}
