// SPDX-License-Identifier: MIT
// Arithmetic of single-precision floats for cores without an FPU (ARMv6-M: Cortex-M0, M0+, M1). The functions have the
// names that compilers call, and take a quarter of the flash of those in libgcc. Their results have the same bits as those
// of an FPU: IEEE 754, rounded to nearest and ties to even, with denormals and infinities. Only the bits of NaN may differ,
// because the standard does not fix them. If this file is linked, it replaces the functions of the compiler's library.
//
// Inside these functions a number is stored as
//   r0  sign in bit 31
//   r2  significand; bit 31 is set, except for a denormal, whose r4 is 1; the last bit is set if any lower bit was lost
//   r4  biased exponent of bit 31
  .syntax unified
  .thumb
#if defined(__ARM_ARCH_6M__)

  .macro function name
  .weak \name
  .type \name, %function
  .thumb_func
\name:
  .endm

  .section .text.floats, "ax"
  .p2align 2

// r0 - r1
  function __aeabi_fsub
  movs r2, #1
  lsls r2, #31
  eors r1, r2
// r0 + r1
  function __aeabi_fadd
  push {r4-r6, lr}
  lsls r2, r0, #1
  lsls r3, r1, #1
  cmp r2, r3
  bhs 1f
  eors r0, r1 // r0 is the larger
  eors r1, r0
  eors r0, r1
  eors r2, r3
  eors r3, r2
  eors r2, r3
1:
  lsrs r4, r2, #24
  cmp r4, #255
  beq not_finite
  lsrs r5, r3, #24
  lsls r2, #8
  lsrs r2, #1
  lsls r3, #8
  lsrs r3, #1
  movs r6, #1
  lsls r6, #31
  cmp r5, #0
  beq small
  orrs r3, r6
  orrs r2, r6
aligned:
  subs r5, r4, r5
  cmp r5, #8 // significands have 24 bits of 32
  bhi far
  lsrs r3, r5
  eors r1, r0
  bmi opposite
alike:
  adds r2, r3
  bcc pack
  lsls r3, r2, #31
  lsrs r3, #31
  lsrs r2, #1
  orrs r2, r3
  movs r3, #1
  lsls r3, #31
  orrs r2, r3
  adds r4, #1
  b pack
opposite:
  subs r2, r3
  beq zero
  bmi pack
  bl normalise
  subs r4, r3
  bgt pack
  movs r3, #1 // shift back to a denormal, which loses no bits
  subs r3, r4
  lsrs r2, r3
  movs r4, #1
  b pack
far:
  cmp r5, #31
  bhi 3f
  movs r6, r3
  lsrs r3, r5
  rsbs r5, #0
  adds r5, #32
  lsls r6, r5
  beq 4f
  movs r6, #1
  orrs r3, r6
  b 4f
3:
  movs r3, #1
4:
  eors r1, r0
  bpl alike
  subs r2, r3
  bmi pack
  lsls r2, #1
  subs r4, #1
  b pack
small: // the smaller is a denormal or zero
  movs r5, #1
  cmp r4, #0
  bne 5f
  movs r4, #1
  b aligned
5:
  orrs r2, r6
  b aligned
not_finite: // the larger operand
  lsls r4, r2, #8
  bne done
  cmp r2, r3
  bne done
  eors r1, r0
  bpl done
  b invalid

// Returns the integer r0 as a float.
  function __aeabi_i2f
  push {r4-r6, lr}
  movs r2, r0
  beq done
  bpl 6f
  rsbs r2, #0
6:
  bl normalise
  movs r4, #158
  subs r4, r3
// Packs the float into a word and returns to the caller.
pack:
  cmp r4, #254
  bgt infinity
  lsrs r0, #31
  lsls r0, #31
  subs r4, #1
  lsls r4, #23
  adds r0, r4
  lsrs r3, r2, #8
  adds r0, r3 // bit 31 of the significand adds the missing 1 to the exponent
  lsls r2, #25
  bcc done
  bne 6f
  lsls r2, r0, #31 // half way: round to even
  bpl done
6:
  adds r0, #1
done:
  pop {r4-r6, pc}
zero:
  movs r0, #0
  pop {r4-r6, pc}
signed_zero:
  movs r2, #0
  b 7f
infinity:
  movs r2, #255
  lsls r2, #23
7:
  lsrs r0, #31
  lsls r0, #31
  orrs r0, r2
  pop {r4-r6, pc}

// Shifts r2, which is not 0, left until bit 31 is set; r3 is the number of bits. Overwrites r1.
  .type normalise, %function
  .thumb_func
normalise:
  movs r3, #0
  lsrs r1, r2, #16
  bne 1f
  lsls r2, #16
  adds r3, #16
1:
  lsrs r1, r2, #24
  bne 2f
  lsls r2, #8
  adds r3, #8
2:
  lsrs r1, r2, #28
  bne 3f
  lsls r2, #4
  adds r3, #4
3:
  lsrs r1, r2, #30
  bne 4f
  lsls r2, #2
  adds r3, #2
4:
  cmp r2, #0
  bmi 5f
  lsls r2, #1
  adds r3, #1
5:
  bx lr

#include "float_products.inc"
#include "float_comparisons.inc"
#endif
