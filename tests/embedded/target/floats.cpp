// SPDX-License-Identifier: MIT
// Arithmetic of floats gives the bits of tests/golden on each core, also with toolchains/cortex_m/floats.S. The
// operands are random bits, neighbouring exponents, sums and products half way between floats, denormals, infinities,
// NaN.
#include <bit>
#include <cstdint>
#include <iterator>

#include "tests/embedded/target/text.h"

#if !defined(NLO_PAIRS)
#define NLO_PAIRS 400'000
#endif

namespace nlo::target {
namespace {

/// xorshift32.
struct Random {
  std::uint32_t state = 2463534242U;
  std::uint32_t operator()() {
    state ^= state << 13;
    state ^= state >> 17;
    return state ^= state << 5;
  }
};

/// A checksum over words; it changes if any word changes.
class Sum {
 public:
  void add(std::uint32_t word) { value_ = std::rotl(value_ ^ word, 5) * 0x9e3779b1U; }
  /// Adds a number; all NaN count as equal.
  void add(float value) { add(value == value ? std::bit_cast<std::uint32_t>(value) : 0x7fc00000U); }
  void write(const char* name) const {
    board::write(name);
    board::write(value_, 16, 8);
    board::write("\n");
  }

 private:
  std::uint32_t value_ = 0;
};

// noinline, so that the compiler neither folds nor fuses the operations.
__attribute__((noinline)) float sum(float a, float b) {
  return a + b;
}
__attribute__((noinline)) float difference(float a, float b) {
  return a - b;
}
__attribute__((noinline)) float product(float a, float b) {
  return a * b;
}
__attribute__((noinline)) float quotient(float a, float b) {
  return a / b;
}

constexpr std::uint32_t kSpecial[] = {
    0,          1,          2,          0x007fffff, 0x00800000, 0x00800001, 0x00ffffff, 0x01000000, 0x33800000,
    0x34000000, 0x3effffff, 0x3f000000, 0x3f7fffff, 0x3f800000, 0x3f800001, 0x3fffffff, 0x40000000, 0x4b000000,
    0x4b7fffff, 0x4b800000, 0x4effffff, 0x4f000000, 0x7f7fffff, 0x7f800000, 0x7fc00000, 0x7f800001};

class Test {
 public:
  void pair(std::uint32_t a_bits, std::uint32_t b_bits) {
    const auto a = std::bit_cast<float>(a_bits), b = std::bit_cast<float>(b_bits);
    sums_.add(sum(a, b));
    differences_.add(difference(a, b));
    products_.add(product(a, b));
    quotients_.add(quotient(a, b));
    comparisons_.add(
        static_cast<std::uint32_t>((a < b) | (a <= b) << 1 | (a > b) << 2 | (a >= b) << 3 | (a == b) << 4));
    integers_.add(static_cast<float>(static_cast<std::int32_t>(a_bits)));
    integers_.add(static_cast<float>(b_bits));
    if (a > -0x1p31F && a < 0x1p31F) integers_.add(static_cast<std::uint32_t>(static_cast<std::int32_t>(a)));
  }

  void write() const {
    sums_.write("sums ");
    differences_.write("differences ");
    products_.write("products ");
    quotients_.write("quotients ");
    comparisons_.write("comparisons ");
    integers_.write("integers ");
  }

 private:
  Sum sums_, differences_, products_, quotients_, comparisons_, integers_;
};

}  // namespace

void run_all() {
  Test test;
  constexpr std::uint32_t kSign = 0x80000000U, kExponent = 0x7f800000U;
  for (const std::uint32_t a : kSpecial) {
    for (const std::uint32_t b : kSpecial) {
      for (const std::uint32_t sign : {std::uint32_t{0}, kSign}) {
        test.pair(a, b ^ sign);
        test.pair(a ^ kSign, b ^ sign);
      }
    }
  }
  Random random;
  for (int k = 0; k < NLO_PAIRS; ++k) {
    std::uint32_t a = random(), b = random();
    const std::uint32_t exponent = a & kExponent;
    if (k % 4 == 1)
      b = (b & ~kExponent) | ((exponent + (random() % 64U << 23U) - (32U << 23U)) & kExponent);  // a close exponent
    if (k % 4 == 2) b = (a ^ (b & kSign)) + random() % 16U;                          // nearly equal operands
    if (k % 4 == 3) b = (b & 0x80fff000U) | ((0x7e800000U - exponent) & kExponent);  // the product is about 1
    if (k % 8 == 7) a &= 0x81ffffffU;                                                // denormals
    if (k % 16 == 9) a &= 0xfffff000U, b &= 0xffffe000U;                             // half way between floats
    test.pair(a, b);
  }
  test.write();
}

}  // namespace nlo::target

int main() {
  nlo::target::run_all();
  return 0;
}
