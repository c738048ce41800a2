// SPDX-License-Identifier: MIT
// Semihosting (toolchains/semihosting.h) on an ATmega328P (Arduino Uno): text goes to the serial port, which simavr prints.
// Sleep with interrupts off ends simavr. Its exit status is always 0, so the status is printed as text.
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
