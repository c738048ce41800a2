// SPDX-License-Identifier: MIT
// Matrix-vector product in int16 with int32 sums, sum = W a + b, and a table of tanh. Sums cannot overflow: the
// exporter chooses scales with |b| + sum |w| 32767 < 2^31 for each output, and refuses a model for which there are
// none. Therefore the order of summation does not matter, and every target gives the same bits.
//
// Instructions per multiply-add on Cortex-M:
//   DSP instructions (M4)  0.7: SMLAD does two multiply-adds. The sums of a block of 5 or 4 outputs stay in registers;
//                          the weights of a pair of inputs are loaded at once.
//   without (M0, M0+)      3.7: the sums stay in the high registers, which only additions can access.
//   MVE (M55)              0.3: VMLADAVA does eight multiply-adds of one row.
// RISC-V: int16_riscv.h.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#if defined(__riscv)
#include "nlo/kernels/int16_riscv.h"
#endif

// The assembly needs optimised code of GCC, because it uses all registers but the stack pointer. Elsewhere plain C++
// gives the same bits.
#if defined(__ARM_FEATURE_DSP) && defined(__ARM_ARCH_PROFILE) && defined(__OPTIMIZE__) && !defined(__clang__) && \
    !defined(NLO_SCALAR_KERNELS)
#if __ARM_ARCH_PROFILE == 'M'
#define NLO_CORTEX_M_DSP 1
#endif
#endif
// The order of the weights depends on the architecture only, not on the optimisation.
#if defined(__ARM_FEATURE_MVE) && !defined(NLO_SCALAR_KERNELS)
#define NLO_CORTEX_M_OCTETS 1
#endif
// Largest layer whose outputs are one block: 3 outputs on ARMv6-M, any number on RISC-V.
#if defined(__riscv)
#define NLO_LARGEST_WHOLE (1 << 30)
#elif defined(__thumb__) && !defined(__thumb2__) && defined(__ARM_ARCH_PROFILE)
#define NLO_LARGEST_WHOLE 3
#else
#define NLO_LARGEST_WHOLE 0
#endif
// GCC does not use the high registers itself when it optimises for size.
#if defined(__thumb__) && !defined(__thumb2__) && defined(__ARM_ARCH_PROFILE) && defined(__OPTIMIZE__) && \
    !defined(__OPTIMIZE_SIZE__) && !defined(__clang__) && !defined(NLO_SCALAR_KERNELS)
#define NLO_CORTEX_M_THUMB1 1
#endif

namespace nlo::inline NLO_ISA::kernels::int16 {

/// Activations are in Q15: 32767 stands for 1 (tanh), for the largest value of the layer (relu), or for 16 (silu).
inline constexpr int kOne = 32767;

/// Blocks of the outputs: 5 or 4 rows each, with rows of zeros at the end if needed; or one block of all rows.
template <int kOut>
struct Blocks {
  static constexpr int kWhole = kOut <= NLO_LARGEST_WHOLE ? kOut : 0;  ///< rows if one block holds all outputs, else 0
  static constexpr int fours(int rows) { return kWhole > 0 ? 0 : (5 - rows % 5) % 5; }
  static constexpr int kRows = [] {
    int rows = kOut;
    while (4 * fours(rows) > rows) ++rows;
    return rows;
  }();
  static constexpr int kFours = fours(kRows);  ///< number of blocks of 4, which follow the blocks of 5
  static constexpr int kFives = (kRows - kWhole - 4 * kFours) / 5;
  static_assert(5 * kFives + 4 * kFours + kWhole == kRows && kFives >= 0);
};
#undef NLO_LARGEST_WHOLE

template <int kIn>
inline constexpr int kPairs = (kIn + 1) / 2;

/// Returns the position of the weight of input i for row r in a block of `size` rows: by pair of inputs, then by row.
constexpr int pair_position(int size, int r, int i) {
  return 2 * (i / 2 * size + r) + i % 2;
}

/// The same for the layout of this target. With vectors (MVE) inputs are grouped by eight; the remaining pairs follow.
constexpr int block_position([[maybe_unused]] int pairs, int size, int r, int i) {
#if defined(__riscv)
  return i * size + r;
#elif defined(NLO_CORTEX_M_OCTETS)
  const int eights = 2 * pairs / 8 * 8;
  return i < eights ? i / 8 * 8 * size + 8 * r + i % 8 : eights * size + (2 * pairs - eights) * r + (i - eights);
#else
  return pair_position(size, r, i);
#endif
}

/// Returns the position of the weight of input i for output o: block by block.
template <int kIn, int kOut>
constexpr int weight_position(int o, int i) {
  if (Blocks<kOut>::kWhole > 0) return block_position(kPairs<kIn>, kOut, o, i);
  const int fives = 5 * Blocks<kOut>::kFives;
  const int size = o < fives ? 5 : 4;
  const int first = o < fives ? o / 5 * 5 : fives + (o - fives) / 4 * 4;
  return 2 * first * kPairs<kIn> + block_position(kPairs<kIn>, size, o - first, i);
}

/// Table of tanh over [-8, 8] in steps of h = 1/32. Linear interpolation between exact points would be too small in
/// magnitude by up to h^2/8 |tanh''|. The points are moved outwards by half of that, so that the error is halved. The
/// ends are +-1.
inline constexpr auto kTanhTable = [] {
  std::array<std::int16_t, 513> table{};
  constexpr double kStep = 1.0 / 32;
  for (int i = 0; i <= 512; ++i) {
    const double t = tanh_rational((i - 256) * kStep);
    const double value = kOne * (t + kStep * kStep / 8 * t * (1 - t * t));
    table[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(value < 0 ? value - 0.5 : value + 0.5);
  }
  return table;
}();

/// Largest |tanh_q15(x) / 32767 - tanh(x)| over all arguments: half from the interpolation, half from rounding.
inline constexpr double kTanhTableMaxError = 1e-4;

/// Returns value * gain rounded to the nearest integer and saturated to Q15. NaN gives 32767.
inline std::int16_t quantised(float value, float gain) {
  constexpr float kLimit = static_cast<float>(kOne);
  float q = rounded(value * gain);
  q = q < kLimit ? q : kLimit;
  q = q > -kLimit ? q : -kLimit;
  return static_cast<std::int16_t>(q < 0 ? q - 0.5F : q + 0.5F);
}

/// Returns value / 2^kShift rounded down and saturated to a signed integer of kBits bits.
template <int kBits, int kShift>
NLO_INLINE std::int32_t shifted_and_saturated(std::int32_t value) {
#if defined(NLO_CORTEX_M_DSP)
  std::int32_t result;
  asm("ssat %0, %2, %1, asr %3" : "=r"(result) : "r"(value), "i"(kBits), "i"(kShift));
  return result;
#else
  constexpr std::int32_t kMax = (1 << (kBits - 1)) - 1;
  value >>= kShift;
  return value > kMax ? kMax : value < -kMax - 1 ? -kMax - 1 : value;
#endif
}

/// Returns tanh in Q15 of an argument in Q16, |argument| <= 8. It rounds down, so the result is half a unit too low on
/// average. The exporter corrects this in the bias of the next layer.
NLO_INLINE std::int32_t tanh_q15(std::int32_t argument) {
  constexpr int kFractionBits = 11;  // 2^16 / 32
  const std::int16_t* at = kTanhTable.data() + 256 + (argument >> kFractionBits);
  const std::int32_t fraction = argument & ((1 << kFractionBits) - 1);
  return at[0] + ((at[1] - at[0]) * fraction >> kFractionBits);
}

/// Returns silu(2 h) = h + h tanh(h) in units of 2^-11, rounded down. h: in Q16.
NLO_INLINE std::int32_t silu_q11(std::int32_t argument) {
  const std::int32_t half = argument >> 4;  // Q12; no product overflows: 2^15 65535 < 2^31
  return (half * (kOne + 1 + tanh_q15(argument))) >> 16;
}

/// Returns the activation of a sum. sum / 2^kShift is the argument in Q16 (tanh), half of the argument in Q16 (silu),
/// or the result in Q15 (relu).
template <Activation kKind, int kShift>
NLO_INLINE std::int16_t activated(std::int32_t sum) {
  static_assert(kKind == Activation::kTanh || kKind == Activation::kRelu || kKind == Activation::kSilu);
  static_assert(kShift >= 1 && kShift <= 31);
  if constexpr (kKind == Activation::kTanh) {
    return static_cast<std::int16_t>(tanh_q15(shifted_and_saturated<20, kShift>(sum)));
  } else if constexpr (kKind == Activation::kSilu) {
    return static_cast<std::int16_t>(silu_q11(shifted_and_saturated<20, kShift>(sum)));
  } else {
#if defined(NLO_CORTEX_M_DSP)
    std::int32_t result;
    asm("usat %0, #15, %1, asr %2" : "=r"(result) : "r"(sum), "i"(kShift));
    return static_cast<std::int16_t>(result);
#else
    return static_cast<std::int16_t>(shifted_and_saturated<16, kShift>(sum & ~(sum >> 31)));
#endif
  }
}

/// Computes the sums of one block: its biases plus kSize rows times all pairs of inputs.
template <int kSize, int kPairCount>
NLO_INLINE void add_block_plain(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                                std::int32_t (&sums)[kSize]) {
  NLO_UNROLL
  for (int r = 0; r < kSize; ++r) sums[r] = bias[r];
  for (int p = 0; p < kPairCount; ++p) {
    NLO_UNROLL
    for (int r = 0; r < kSize; ++r) {
      const auto weight = [&](int i) NLO_INLINE_LAMBDA { return weights[block_position(kPairCount, kSize, r, i)]; };
      sums[r] += weight(2 * p) * in[2 * p] + weight(2 * p + 1) * in[2 * p + 1];
    }
  }
}

#if defined(NLO_CORTEX_M_OCTETS) && defined(NLO_CORTEX_M_DSP)

// Eight inputs are in q0; eight weights of one row at a time are loaded into q1 or q2.
#define NLO_ROW(q, sum)   \
  "vldrh.u16 " q          \
  ", [%[weights]], #16\n" \
  "vmladava.s16 " sum ", q0, " q "\n"
#define NLO_ROW_OF_TAIL(r, q, sum)                     \
  "vpst\n"                                             \
  "vldrht.u16 " q ", [%[weights], #2 * %c[tail] * " #r \
  "]\n"                                                \
  "vmladava.s16 " sum ", q0, " q "\n"

/// Not inlined, so that layers with equally many inputs share the code.
template <int kSize, int kPairCount>
__attribute__((noinline)) void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                                         std::int32_t (&sums)[kSize]) {
  static_assert(kSize == 4 || kSize == 5);
  register std::int32_t sum0 asm("r0") = bias[0];
  register std::int32_t sum1 asm("r2") = bias[1];
  register std::int32_t sum2 asm("r4") = bias[2];
  register std::int32_t sum3 asm("r6") = bias[3];
  register std::int32_t sum4 asm("r8") = bias[kSize - 1];
  asm volatile(
      ".if %c[eights]\n"
      "dls lr, %[count]\n"
      "1:\n"
      "vldrh.u16 q0, [%[in]], #16\n" NLO_ROW("q1", "r0") NLO_ROW("q2", "r2") NLO_ROW("q1", "r4") NLO_ROW("q2", "r6")
      ".if %c[size] == 5\n" NLO_ROW("q1", "r8")
      ".endif\n"
      "le lr, 1b\n"
      ".endif\n"
      ".if %c[tail]\n"
      "mov lr, #%c[tail]\n"
      "vctp.16 lr\n"
      "vpst\n"
      "vldrht.u16 q0, [%[in]]\n" NLO_ROW_OF_TAIL(0, "q1", "r0") NLO_ROW_OF_TAIL(1, "q2", "r2")
          NLO_ROW_OF_TAIL(2, "q1", "r4") NLO_ROW_OF_TAIL(3, "q2", "r6")
      ".if %c[size] == 5\n" NLO_ROW_OF_TAIL(4, "q1", "r8")
      ".endif\n"
      ".endif\n"
      : [weights] "+r"(weights), [in] "+r"(in), "+r"(sum0), "+r"(sum1), "+r"(sum2), "+r"(sum3), "+r"(sum4)
      : [count] "r"(kPairCount / 4), [eights] "i"(kPairCount / 4), [tail] "i"(2 * (kPairCount % 4)), [size] "i"(kSize)
      : "lr", "q0", "q1", "q2", "memory");
  sums[0] = sum0;
  sums[1] = sum1;
  sums[2] = sum2;
  sums[3] = sum3;
  if constexpr (kSize == 5) sums[4] = sum4;
}

#undef NLO_ROW_OF_TAIL
#undef NLO_ROW

#elif defined(NLO_CORTEX_M_DSP) && !defined(NLO_CORTEX_M_OCTETS)

// Weights of a pair of inputs: r0-r3 and r11. The pair: r10. Sums: r4-r6, r8 and r9.
#define NLO_PAIR_4               \
  "ldr r10, [%[in]], #4\n"       \
  "ldmia %[weights]!, {r0-r3}\n" \
  "smlad r4, r0, r10, r4\n"      \
  "smlad r5, r1, r10, r5\n"      \
  "smlad r6, r2, r10, r6\n"      \
  "smlad r8, r3, r10, r8\n"
#define NLO_PAIR_5                    \
  "ldr r10, [%[in]], #4\n"            \
  "ldmia %[weights]!, {r0-r3, r11}\n" \
  "smlad r4, r0, r10, r4\n"           \
  "smlad r5, r1, r10, r5\n"           \
  "smlad r6, r2, r10, r6\n"           \
  "smlad r8, r3, r10, r8\n"           \
  "smlad r9, r11, r10, r9\n"

/// Processes kPairCount pairs without a loop, because no register is left for a counter.
template <int kSize, int kPairCount>
NLO_INLINE void add_run(const std::int16_t*& weights, const std::int16_t*& in, const std::int32_t* from,
                        std::int32_t (&sums)[kSize]) {
  register std::int32_t sum0 asm("r4") = from[0];
  register std::int32_t sum1 asm("r5") = from[1];
  register std::int32_t sum2 asm("r6") = from[2];
  register std::int32_t sum3 asm("r8") = from[3];
  if constexpr (kSize == 5) {
    register std::int32_t sum4 asm("r9") = from[4];
    asm volatile(".rept %c[pairs]\n" NLO_PAIR_5 ".endr\n"
                 : [weights] "+r"(weights), [in] "+r"(in), "+r"(sum0), "+r"(sum1), "+r"(sum2), "+r"(sum3), "+r"(sum4)
                 : [pairs] "i"(kPairCount)
                 : "r0", "r1", "r2", "r3", "r10", "r11", "memory");
    sums[4] = sum4;
  } else {
    asm volatile(".rept %c[pairs]\n" NLO_PAIR_4 ".endr\n"
                 : [weights] "+r"(weights), [in] "+r"(in), "+r"(sum0), "+r"(sum1), "+r"(sum2), "+r"(sum3)
                 : [pairs] "i"(kPairCount)
                 : "r0", "r1", "r2", "r3", "r10", "memory");
  }
  sums[0] = sum0;
  sums[1] = sum1;
  sums[2] = sum2;
  sums[3] = sum3;
}

/// Not inlined, because within other code GCC runs out of registers.
template <int kSize, int kPairCount>
__attribute__((noinline)) void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                                         std::int32_t (&sums)[kSize]) {
  static_assert(kSize == 4 || kSize == 5);
  constexpr int kLongest = 32;  // takes 0.9 KB of code
  if constexpr (kPairCount <= kLongest) {
    add_run<kSize, kPairCount>(weights, in, bias, sums);
  } else {
    add_run<kSize, kLongest>(weights, in, bias, sums);
    for (int rounds = kPairCount / kLongest; rounds > 1; --rounds) add_run<kSize, kLongest>(weights, in, sums, sums);
    if constexpr (kPairCount % kLongest != 0) add_run<kSize, kPairCount % kLongest>(weights, in, sums, sums);
  }
}

#undef NLO_PAIR_5
#undef NLO_PAIR_4

#elif defined(NLO_CORTEX_M_THUMB1)

// The inputs of a pair: r5 and r4. The weights of two or three rows: r0, r1, r3.
#define NLO_ROW(weights, sum)  \
  "sxth r2, " weights          \
  "\n"                         \
  "asrs " weights ", " weights \
  ", #16\n"                    \
  "muls r2, r5\n"              \
  "muls " weights              \
  ", r4\n"                     \
  "add " sum                   \
  ", r2\n"                     \
  "add " sum ", " weights "\n"

/// Computes the sums over the inputs up to `in_end`, at least one pair. Not inlined, because it uses all registers but
/// the stack pointer.
template <int kSize>
__attribute__((noinline)) void add_pairs(const std::int16_t* weights, const std::int16_t* in,
                                         const std::int16_t* in_end, const std::int32_t* bias,
                                         std::int32_t (&sums)[kSize]) {
  static_assert(kSize >= 1 && kSize <= 5);
  register const std::int16_t* end asm("lr") = in_end;
  register std::int32_t sum0 asm("r8") = bias[0];
  register std::int32_t sum1 asm("r9") = bias[kSize > 1 ? 1 : 0];
  register std::int32_t sum2 asm("r10") = bias[kSize > 2 ? 2 : 0];
  register std::int32_t sum3 asm("r11") = bias[kSize > 3 ? 3 : 0];
  register std::int32_t sum4 asm("r12") = bias[kSize - 1];
  asm volatile(
      ".syntax unified\n"
      "1:\n"
      "ldmia %[in]!, {r4}\n"
      "sxth r5, r4\n"
      "asrs r4, r4, #16\n"
      ".if %c[size] == 1\n"
      "ldmia %[weights]!, {r0}\n" NLO_ROW("r0", "r8")
      ".else\n"
      "ldmia %[weights]!, {r0, r1}\n" NLO_ROW("r0", "r8") NLO_ROW("r1", "r9")
      ".endif\n"
      ".if %c[size] == 3\n"
      "ldmia %[weights]!, {r0}\n"
      ".elseif %c[size] == 4\n"
      "ldmia %[weights]!, {r0, r1}\n"
      ".elseif %c[size] == 5\n"
      "ldmia %[weights]!, {r0, r1, r3}\n"
      ".endif\n"
      ".if %c[size] >= 3\n" NLO_ROW("r0", "r10")
      ".endif\n"
      ".if %c[size] >= 4\n" NLO_ROW("r1", "r11")
      ".endif\n"
      ".if %c[size] == 5\n" NLO_ROW("r3", "r12") ".endif\n"
      "cmp %[in], %[end]\n"
      "bne 1b\n"
      : [weights] "+l"(weights), [in] "+l"(in), "+h"(sum0), "+h"(sum1), "+h"(sum2), "+h"(sum3), "+h"(sum4)
      : [end] "h"(end), [size] "i"(kSize)
      : "r0", "r1", "r2", "r3", "r4", "r5", "cc", "memory");
  sums[0] = sum0;
  if constexpr (kSize > 1) sums[1] = sum1;
  if constexpr (kSize > 2) sums[2] = sum2;
  if constexpr (kSize > 3) sums[3] = sum3;
  if constexpr (kSize > 4) sums[4] = sum4;
}

template <int kSize, int kPairCount>
NLO_INLINE void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                          std::int32_t (&sums)[kSize]) {
  add_pairs<kSize>(weights, in, in + 2 * kPairCount, bias, sums);
}

#undef NLO_ROW

#elif !defined(__riscv)

template <int kSize, int kPairCount>
NLO_INLINE void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                          std::int32_t (&sums)[kSize]) {
  add_block_plain<kSize, kPairCount>(weights, in, bias, sums);
}

#endif

/// Computes one layer. Calls write(o, sum) for each row o, rows of padding included. `weights` has the order of
/// weight_position(), `bias` has Blocks::kRows values, `in` has 2 kPairs<kIn>. weights and in are 4-byte aligned.
template <int kIn, int kOut, class Write>
NLO_INLINE void layer(const std::int16_t* weights, const std::int32_t* bias, const std::int16_t* in, Write write) {
  using B = Blocks<kOut>;
  const auto block = [&]<int kSize>(std::integral_constant<int, kSize>, int first) NLO_INLINE_LAMBDA {
    std::int32_t sums[kSize];
    add_block<kSize, kPairs<kIn>>(weights + 2 * kPairs<kIn> * first, in, bias + first, sums);
    if constexpr (kSize <= 5) {
      NLO_UNROLL
      for (int r = 0; r < kSize; ++r) write(first + r, sums[r]);
    } else {
      for (int r = 0; r < kSize; ++r) write(first + r, sums[r]);
    }
  };
  if constexpr (B::kWhole > 0) block(std::integral_constant<int, B::kWhole>{}, 0);
  for (int b = 0; b < B::kFives; ++b) block(std::integral_constant<int, 5>{}, 5 * b);
  for (int b = 0; b < B::kFours; ++b) block(std::integral_constant<int, 4>{}, 5 * B::kFives + 4 * b);
}

}  // namespace nlo::inline NLO_ISA::kernels::int16
