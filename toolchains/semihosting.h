/* SPDX-License-Identifier: MIT */
/* The two things a program on an emulated board wants from its host: a line of text, and an end. */
#ifndef NLO_SEMIHOSTING_H
#define NLO_SEMIHOSTING_H

#ifdef __cplusplus
extern "C" {
#endif

/* Writes a string to the host's terminal. */
void board_write(const char* text);

/* Ends the emulator: exit status 0 for 0, else 1. */
void board_exit(int status) __attribute__((noreturn));

/* Every exception without a handler of its own: says so and ends the emulator. */
void Fault_Handler(void);

#ifdef __cplusplus
}
#endif

#endif
