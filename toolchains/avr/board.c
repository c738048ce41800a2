// SPDX-License-Identifier: MIT
// What toolchains/semihosting.h has, on an ATmega328P (Arduino Uno): text leaves by the serial port, which simavr prints, and
// sleep with interrupts off is what ends simavr. Its exit status is 0 whatever happened: the status is told as text.
#include "../semihosting.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

void board_write(const char* text) {
  UCSR0B = _BV(TXEN0);
  for (; *text != '\0'; ++text) {
    while ((UCSR0A & _BV(UDRE0)) == 0) {
    }
    UDR0 = (uint8_t)*text;
  }
}

void board_exit(int status) {
  board_write(status == 0 ? "exit status 0\n" : "exit status 1\n");
  while ((UCSR0A & _BV(UDRE0)) == 0) {
  }
  cli();
  sleep_enable();
  for (;;) sleep_cpu();
}
