/* SPDX-License-Identifier: MIT */
/* Lets a program on an emulated board print a line of text on its host, and end the emulator. */
#ifndef NLO_SEMIHOSTING_H
#define NLO_SEMIHOSTING_H

#ifdef __cplusplus
extern "C" {
#endif

/* Writes a string to the host's terminal. */
void board_write(const char* text);

/* Ends the emulator: exit status 0 for 0, else 1. */
void board_exit(int status) __attribute__((noreturn));

/* Handles each exception without a handler of its own: reports it and ends the emulator. */
void Fault_Handler(void);

#ifdef __cplusplus
}
#endif

#endif
