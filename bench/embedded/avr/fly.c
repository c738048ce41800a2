// SPDX-License-Identifier: MIT
// The smallest program that runs a C99 export on an ATmega328P, to measure its size: it computes a sample at each tick
// of the timer and writes the first state of the estimate to a port.
#include <avr/io.h>

#include NLO_HEADER

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(word) JOIN(NLO_NAME, _##word)

static OF(observer) observer;

int main(void) {
  DDRB = 0xff;
  OF(init)(&observer);
  TCCR1B = _BV(WGM12) | _BV(CS11);
  OCR1A = 39999;  // 20 ms at 16 MHz
  for (;;) {
    while ((TIFR1 & _BV(OCF1A)) == 0) {
    }
    TIFR1 = _BV(OCF1A);
    float y[OF(NY)], x_hat[OF(NX)];
    for (int j = 0; j < OF(NY); ++j) y[j] = (float)ADC * (6.0f / 1023.0f) - 3.0f;
    OF(step)(&observer, y);
    OF(estimate)(&observer, x_hat);
    PORTB = OF(in_domain)(&observer) && x_hat[0] > 0.0f;
  }
}
