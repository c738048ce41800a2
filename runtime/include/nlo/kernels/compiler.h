// SPDX-License-Identifier: MIT
// The language version that the runtime needs, and NLO_ISA: the instruction sets that the compiler may use, as an
// identifier such as isa_sse42_avx_avx2_fma_bmi2.
//
// All functions of the runtime are in an inline namespace of this name, so that a program may link objects that were
// compiled with different -march options. Without it, functions of two objects would have the same symbol. The linker
// would keep one of them, and the other object would run instructions that its CPU may not have, or round differently.
// Types that functions of a program exchange (Vector, StepStatus, Alarm ...) are not in this namespace.
#pragma once

// Every header includes this one first, so that an older language version gives a single error with the remedy.
#if __cplusplus < 202002L
#error "nlo needs C++20: compile with -std=c++20 or -std=gnu++20 (CMake: link nlo::runtime, which asks for it)"
// This file does not exist. A missing file stops the compiler; #error alone would be followed by hundreds of errors.
#define NLO_STOP "nlo/stopped_by_the_error_above"
#include NLO_STOP
#endif

#if defined(__SSE4_2__)
#define NLO_ISA_SSE42 _sse42
#else
#define NLO_ISA_SSE42
#endif
#if defined(__AVX__)
#define NLO_ISA_AVX _avx
#else
#define NLO_ISA_AVX
#endif
#if defined(__AVX2__)
#define NLO_ISA_AVX2 _avx2
#else
#define NLO_ISA_AVX2
#endif
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
#define NLO_ISA_FMA _fma
#else
#define NLO_ISA_FMA
#endif
#if defined(__BMI2__)
#define NLO_ISA_BMI2 _bmi2
#else
#define NLO_ISA_BMI2
#endif
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
#define NLO_ISA_AVX512 _avx512vl
#elif defined(__AVX512F__)
#define NLO_ISA_AVX512 _avx512
#else
#define NLO_ISA_AVX512
#endif
#if defined(__ARM_FEATURE_SVE)
#define NLO_ISA_VECTORS _sve
#elif defined(__ARM_FEATURE_MVE)
#define NLO_ISA_VECTORS _mve
#elif defined(__ARM_NEON)
#define NLO_ISA_VECTORS _neon
#elif defined(__riscv_vector)
#define NLO_ISA_VECTORS _v
#else
#define NLO_ISA_VECTORS
#endif

#define NLO_ISA_JOINED(sse42, avx, avx2, fma, bmi2, avx512, vectors) isa##sse42##avx##avx2##fma##bmi2##avx512##vectors
#define NLO_ISA_JOIN(...) NLO_ISA_JOINED(__VA_ARGS__)
#define NLO_ISA \
  NLO_ISA_JOIN(NLO_ISA_SSE42, NLO_ISA_AVX, NLO_ISA_AVX2, NLO_ISA_FMA, NLO_ISA_BMI2, NLO_ISA_AVX512, NLO_ISA_VECTORS)
