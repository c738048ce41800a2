// SPDX-License-Identifier: MIT
// Reset of the emulated board `virt`, 32-bit RISC-V: a stack, zeros in .bss, main. Constants and .data lie in RAM already.
  .section .init, "ax"
  .global _start
_start:
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
