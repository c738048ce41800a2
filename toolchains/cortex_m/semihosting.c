// SPDX-License-Identifier: MIT
#include "../semihosting.h"

enum { kWriteString = 4, kExit = 0x18 };

// The breakpoint that a debugger or an emulator answers: operation in r0, its argument in r1.
static void call_host(int operation, const void* argument) {
  register int r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void board_write(const char* text) {
  call_host(kWriteString, text);
}

void board_exit(int status) {
  const unsigned application_exit = 0x20026, run_time_error = 0x20023;
  call_host(kExit, (const void*)(status == 0 ? application_exit : run_time_error));
  for (;;) {
  }
}

void Fault_Handler(void) {
  board_write("fault\n");
  board_exit(1);
}
