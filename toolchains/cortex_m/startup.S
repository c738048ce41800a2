// SPDX-License-Identifier: MIT
// Vector table and reset of a Cortex-M. The FPU is switched on here, before any C: at -O2 a compiler saves FPU registers
// in a function's first instructions, and with the FPU off that is a fault.
  .syntax unified
  .thumb

  .section .vectors, "a"
  .word stack_top
  .word Reset_Handler
  .rept 13  // NMI, the faults, SVCall, debug, PendSV and what is reserved
  .word unexpected
  .endr
  .word SysTick_Handler

  .weak SysTick_Handler
  .thumb_set SysTick_Handler, unexpected

  .text
  .thumb_func
unexpected:
  bl Fault_Handler

  .thumb_func
  .global Reset_Handler
Reset_Handler:
#if defined(__ARM_FP)
  ldr r0, =0xE000ED88  // CPACR: full access to coprocessors 10 and 11
  ldr r1, [r0]
  ldr r2, =0x00F00000
  orrs r1, r2
  str r1, [r0]
  dsb
  isb
#endif
  ldr r0, =data_load_start  // .data from flash; the linker aligns all of its ends to words
  ldr r1, =data_start
  ldr r2, =data_end
  b 2f
1:
  ldmia r0!, {r3}
  stmia r1!, {r3}
2:
  cmp r1, r2
  blo 1b
  ldr r1, =bss_start
  ldr r2, =bss_end
  movs r3, #0
  b 4f
3:
  stmia r1!, {r3}
4:
  cmp r1, r2
  blo 3b
  ldr r4, =init_array_start
  ldr r5, =init_array_end
  b 6f
5:
  ldmia r4!, {r0}
  blx r0
6:
  cmp r4, r5
  blo 5b
  bl main
  bl board_exit
  .pool
