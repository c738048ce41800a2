// SPDX-License-Identifier: MIT
#include "../semihosting.h"

#include <stdint.h>

enum { kWriteString = 4, kExit = 0x18 };

// The sequence that a debugger or an emulator answers: operation in a0, its argument in a1. Its three instructions must
// not be compressed, and must be on one page.
static void call_host(int operation, const void* argument) {
  register int a0 __asm__("a0") = operation;
  register const void* a1 __asm__("a1") = argument;
  __asm__ volatile(
      ".balign 16\n.option push\n.option norvc\n"
      "slli zero, zero, 0x1f\nebreak\nsrai zero, zero, 7\n"
      ".option pop"
      : "+r"(a0)
      : "r"(a1)
      : "memory");
}

void board_write(const char* text) {
  call_host(kWriteString, text);
}

void board_exit(int status) {
  const uintptr_t application_exit = 0x20026, run_time_error = 0x20023;
  const uintptr_t reason = status == 0 ? application_exit : run_time_error;
#if __riscv_xlen == 32
  call_host(kExit, (const void*)reason);
#else
  const uintptr_t block[2] = {reason, 0};
  call_host(kExit, block);
#endif
  for (;;) {
  }
}
