// SPDX-License-Identifier: MIT
// Prints a C++ program that compares a few thousand literals, as its compiler reads them, with the bits that they stand
// for. With an argument, one bit is wrong: the control.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <type_traits>

#include "codegen/base/number.h"

namespace {

template <class Scalar>
std::string cases(std::uint64_t corrupt) {
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;
  using Limits = std::numeric_limits<Scalar>;
  constexpr int kRandom = 3000;
  std::string text;
  const auto add = [&](Scalar value) {
    text += fmt::format("    {{{}, {:#x}U}},\n", nlo::codegen::literal(value), std::bit_cast<Bits>(value) ^ corrupt);
    corrupt = 0;
  };
  for (const Scalar edge : {Scalar(0), Limits::denorm_min(), Limits::min(), std::nextafter(Limits::min(), Scalar(0)),
                            Limits::max(), Limits::epsilon(), Scalar(0.1), Scalar(16777217)}) {
    add(edge);
    add(-edge);
  }
  std::mt19937_64 random(7);
  for (int i = 0; i < kRandom; ++i) {
    const auto value = std::bit_cast<Scalar>(static_cast<Bits>(random()));
    if (std::isfinite(value)) add(value);
  }
  return text;
}

}  // namespace

int main(int argc, char**) {
  fmt::print(
      "#include <bit>\n#include <cstdint>\n"
      "struct Single {{ float value; std::uint32_t bits; }};\n"
      "struct Double {{ double value; std::uint64_t bits; }};\n"
      "constexpr Single kSingle[] = {{\n{}}};\nconstexpr Double kDouble[] = {{\n{}}};\n"
      "int main() {{\n"
      "  for (const Single& c : kSingle) if (std::bit_cast<std::uint32_t>(c.value) != c.bits) return 3;\n"
      "  for (const Double& c : kDouble) if (std::bit_cast<std::uint64_t>(c.value) != c.bits) return 3;\n"
      "}}\n",
      cases<float>(0), cases<double>(argc > 1 ? 1 : 0));
}
