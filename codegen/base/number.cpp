// SPDX-License-Identifier: MIT
#include "codegen/base/number.h"

#include <charconv>
#include <cmath>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
std::string shortest(Scalar value) {
  if (!std::isfinite(value))
    throw Error("a number that is not finite cannot be written; train again, or use the last good checkpoint");
  char text[32];  // the longest double is 24 characters
  std::string digits(text, std::to_chars(text, text + sizeof text, value).ptr);
  if (digits.find_first_of(".e") == std::string::npos) digits += ".0";
  return digits;
}

}  // namespace

std::string literal(float value) {
  return shortest(value) + "f";
}
std::string literal(double value) {
  return shortest(value);
}

}  // namespace nlo::codegen
