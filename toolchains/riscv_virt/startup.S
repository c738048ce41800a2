// SPDX-License-Identifier: MIT
// Reset of the emulated board `virt`, 32-bit or 64-bit RISC-V: turns on the FPU and the vectors if there
// are any, sets the stack, clears .bss and calls main. Constants and .data are in RAM already.
  .section .init, "ax"
  .global _start
_start:
#if defined(__riscv_flen)
  li t0, 0x2200  // mstatus.FS and VS
  csrs mstatus, t0
#endif
  la sp, stack_top
  la t0, bss_start
  la t1, bss_end
  j 2f
1:
  sw zero, 0(t0)
  addi t0, t0, 4
2:
  bltu t0, t1, 1b
  call main
  call board_exit
